#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/image/image.h"

/// Pictures and maps of one scene that a reader of the page flips between in place, zooms, compares and reads values
/// from: what evaluation/report/web/page.js shows. docs/viewer.md is the manual.
namespace dualpixel::evaluation {

enum class LayerColors {
  picture,    ///< sRGB, three channels, 0..1
  light,      ///< linear light, low ... high as black ... white
  gray,       ///< low ... high as equal steps from black to white
  diverging,  ///< -high ... high in the colors of diverging_colors()
};

/// One image of each result, or a single one that all results share.
struct ViewerLayer {
  std::string name;  ///< also what other layers call it
  std::string note;  ///< a sentence or two
  std::string unit;
  LayerColors colors = LayerColors::picture;
  double low = 0, high = 1;
  double step = 1.0 / 1024;  ///< values of maps are rounded to multiples; larger where they would not fit in 16 bits
  /// Of three channels: at the size at which it is shown, kept as JPEG. Of one channel: a map at its file's size, of
  /// which every n-th pixel each way is kept, unchanged, where it is wider than kViewerWidthPx. Empty: the result has
  /// none.
  std::vector<Image> images = {};
  /// Instead of images: the first named layer minus the second, the first scaled and offset by result's fit.
  std::optional<std::pair<std::string, std::string>> difference_of = {};
  std::vector<std::pair<double, double>> fits = {};  ///< scale and offset of each result; empty: 1 and 0
  std::string against = {};                          ///< name of the layer that this one is compared with first
};

inline constexpr int kViewerWidthPx = 1344;

struct Viewer {
  int width = 0, height = 0;         ///< all layers cover this frame, whatever their own size
  std::vector<std::string> results;  ///< names; one or more
  std::vector<ViewerLayer> layers;
};

/// A `<figure>`. Layers without images are left out. All text is escaped.
std::string html_viewer(const Viewer& viewer);

/// One channel as deflated bytes: each value over `step`, rounded, as the difference from what its neighbors predict.
std::string pack_map(const Image& map, double step);

}  // namespace dualpixel::evaluation
