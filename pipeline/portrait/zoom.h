#pragma once
#include <optional>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "pipeline/portrait/options.h"
#include "pipeline/portrait/result_io.h"

/// The paper's forced zoom (Wadhwa et al. 2018, section 2): a portrait shows the middle of what the camera sees, so
/// that one steps back, and faces are not distorted by nearness.
namespace dualpixel::pipeline {

inline constexpr double kZoom = 1.5;  ///< of either side

/// A part of a picture, in its pixels.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;
};

bool holds_center(const Window& window, const Face& face);

/// The middle of the camera's picture, 1 / kZoom as wide and as high, down to whole DP pixels and whole 2 x 2
/// photosites (rows: 4, as captures have them). `photosites`: the picture comes as a mosaic or views; a finished one is
/// cut anywhere. Throws InputError where nothing would be left.
Window zoom_window(const Camera& camera, bool photosites);

/// The window of a map of the camera's whole picture, of any size: it is stretched over the picture. Empty stays empty.
Image cut(const Image& map, const Window& window, const Camera& camera);

/// The part of the picture that a stored result shows, as its provenance says; none: the whole. Throws InputError,
/// which names the result's file, where that is no window.
std::optional<Window> window_of(const StoredResult& stored, const std::string& result_path);

/// What the camera would have delivered with a sensor as small as the window, truth included: the same pixels, the
/// principal point and the face moved. A face whose center is cut away is left out, and lens shading, which is known of
/// the whole picture's places.
Capture zoomed(const Capture& capture, const Window& window);
/// The same for a window that a stored result names: throws InputError where it does not lie in the capture's picture,
/// or between its DP pixels.
Capture zoomed(const Capture& capture, const Window& window, const std::string& result_path);

/// The options' faces, tap, picture and disparity in the window's pixels. Throws InputError where it cuts the center
/// of a face or of the tap away. `camera` is the whole picture's; faces and tap are upright, the window is the
/// capture's.
PortraitOptions zoomed(PortraitOptions options, const Window& window, const Camera& camera);

}  // namespace dualpixel::pipeline
