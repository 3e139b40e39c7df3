#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/names.h"

/// What may be kept of a capture, picture by picture.
namespace dualpixel::datasets {

enum class Layout { exr, npy, dpdd, google };
inline constexpr Named<Layout> kLayouts[] = {
    {"exr", Layout::exr, "a file for each picture: one channel Y, or R, G, B"},
    {"npy", Layout::npy, "a NumPy file for each picture: height x width, or height x width x 3"},
    {"dpdd", Layout::dpdd, "16-bit sRGB PNG: source_c, source_l, source_r and target, as the DPDD data set has them"},
    {"google", Layout::google, "raw views, picture, depth and confidence, as Google's dual-pixel data has them"}};

/// Whether the layout says by itself which pictures there are.
inline bool has_own_pictures(Layout layout) { return layout == Layout::dpdd || layout == Layout::google; }

/// Which pixels a picture has: the sensor's photosites, or the views' DP pixels.
enum class Grid { sensor, views };

struct PictureKind {
  const char* name;
  Grid grid;
  int channels;
  Image (*make)(const Capture& capture);  ///< of the first frame and its truth
  const char* description;
  bool infinite = false;  ///< infinity is one of its values: depth where nothing is seen
};

/// All of them. A capture that is dense (DP pixels of 1 x 1) has one grid.
const std::vector<PictureKind>& pictures();

/// Bytes of a sample's pictures before compression. Throws InputError where the layout does not fit the camera.
std::uint64_t picture_bytes(const Camera& camera, Layout layout, const std::vector<std::string>& keep);

/// The names of a sample's files of pictures, in order.
std::vector<std::string> picture_files(Layout layout, const std::vector<std::string>& keep);

/// Writes the pictures into a folder. Throws InputError that names a picture whose values are not finite.
void write_pictures(const Capture& capture, Layout layout, const std::vector<std::string>& keep,
                    const std::string& folder);

}  // namespace dualpixel::datasets
