#include "pipeline/portrait/zoom.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "capture/error.h"
#include "capture/image/resample.h"
#include "capture/json_fields.h"
#include "capture/views.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kMostSide_px = 65536;

/// Start and length along an axis of `size` px, in whole steps.
std::pair<int, int> middle(int size, int step) {
  const int length = static_cast<int>(size / kZoom) / step * step;
  return {(size - length) / 2 / step * step, length};
}

template <typename Pixel>
ImageOf<Pixel> cut_pixels(const ImageOf<Pixel>& image, const Window& window) {
  if (image.empty()) return {};
  ImageOf<Pixel> part(window.width, window.height, image.channels);
  for (int y = 0; y < window.height; ++y) {
    std::copy_n(image.row(window.y + y) + static_cast<std::ptrdiff_t>(window.x) * image.channels,
                static_cast<std::ptrdiff_t>(window.width) * image.channels, part.row(y));
  }
  return part;
}

Window of_views(const Window& window, const Camera& camera) {
  return {window.x / camera.dp_downsample_x, window.y / camera.dp_downsample_y, window.width / camera.dp_downsample_x,
          window.height / camera.dp_downsample_y};
}

Truth zoomed(const Truth& truth, const Window& window) {
  Truth part = truth;
  for (Image Truth::*image :
       {&Truth::depth_m, &Truth::blur_px, &Truth::disparity_dp_px, &Truth::normal, &Truth::person_mask, &Truth::valid,
        &Truth::all_in_focus, &Truth::photograph, &Truth::left, &Truth::right, &Truth::samples, &Truth::render_sigma,
        &Truth::views_sigma, &Truth::all_in_focus_sigma, &Truth::photograph_sigma}) {
    part.*image = cut_pixels(truth.*image, window);
  }
  part.object_id = cut_pixels(truth.object_id, window);
  for (Image& motion : part.motion) motion = cut_pixels(motion, window);
  return part;
}

Face moved(Face face, const Window& window, const char* what) {
  if (!holds_center(window, face)) {
    throw InputError(
        fmt::format("zoom: {} at {:g}, {:g}: its center is cut away: the picture's middle begins at {}, "
                    "{} and has {} x {} pixels",
                    what, face.x, face.y, window.x, window.y, window.width, window.height));
  }
  face.x -= window.x;
  face.y -= window.y;
  return face;
}

}  // namespace

bool holds_center(const Window& window, const Face& face) {
  const double x = face.x + face.width / 2 - window.x, y = face.y + face.height / 2 - window.y;
  return x >= 0 && x <= window.width && y >= 0 && y <= window.height;
}

Window zoom_window(const Camera& camera, bool photosites) {
  const auto [x, width] = middle(camera.width_px, photosites ? std::lcm(2, camera.dp_downsample_x) : 1);
  const auto [y, height] = middle(camera.height_px, photosites ? std::lcm(4, camera.dp_downsample_y) : 1);
  if (width == 0 || height == 0) {
    throw InputError(
        fmt::format("zoom: a picture of {} x {} pixels is too small for it", camera.width_px, camera.height_px));
  }
  return {x, y, width, height};
}

Image cut(const Image& map, const Window& window, const Camera& camera) {
  if (map.empty()) return {};
  if (map.width == camera.width_px && map.height == camera.height_px) return cut_pixels(map, window);
  const int width = camera.width_px, height = camera.height_px;
  return cut_pixels(map.width > width ? resize_area(map, width, height) : resize_bilinear(map, width, height), window);
}

Capture zoomed(const Capture& capture, const Window& window) {
  Capture part = capture;
  for (Frame& frame : part.frames) {
    frame.mosaic = cut_pixels(frame.mosaic, window);
    for (ImageU16* view : {&frame.left, &frame.right}) *view = cut_pixels(*view, of_views(window, capture.camera));
  }
  if (capture.truth) part.truth = zoomed(*capture.truth, window);
  part.camera.width_px = window.width;
  part.camera.height_px = window.height;
  part.camera.principal_point_px[0] -= window.x;
  part.camera.principal_point_px[1] -= window.y;
  part.camera.relative_light = {};
  if (capture.face_px) {
    const auto& [x, y, width, height] = *capture.face_px;
    if (holds_center(window, {x, y, width, height})) {
      part.face_px = {{x - window.x, y - window.y, width, height}};
    } else {
      part.face_px.reset();
    }
  }
  return part;
}

std::optional<Window> window_of(const StoredResult& stored, const std::string& result_path) {
  const nlohmann::json& provenance = stored.json["provenance"];
  const auto found = provenance.find("window_px");
  if (found == provenance.end()) return {};
  const std::string file = result_path + "/result.json";
  std::array<double, 4> numbers{};
  Fields(provenance, file, "/provenance").numbers("window_px", numbers.data(), 4);
  for (const double number : numbers) {
    if (number >= 0 && number <= kMostSide_px && number == std::floor(number)) continue;
    throw InputError(fmt::format("{}: /provenance/window_px: {}: must be x, y, width, height in whole pixels",
                                 printable(file), number));
  }
  return Window{static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), static_cast<int>(numbers[2]),
                static_cast<int>(numbers[3])};
}

Capture zoomed(const Capture& capture, const Window& window, const std::string& result_path) {
  const Camera& camera = capture.camera;
  const int mosaic = capture.frames[0].mosaic.empty() ? 1 : 2;  // cut between its squares of 2 x 2
  const bool finished = !holds_photosites(capture);
  const int step_x = finished ? 1 : std::max(1, std::lcm(mosaic, camera.dp_downsample_x));
  const int step_y = finished ? 1 : std::max(1, std::lcm(mosaic, camera.dp_downsample_y));
  const bool inside = window.width > 0 && window.height > 0 && window.x + window.width <= camera.width_px &&
                      window.y + window.height <= camera.height_px;
  if (!inside || window.x % step_x || window.width % step_x || window.y % step_y || window.height % step_y) {
    throw InputError(fmt::format(
        "{}/result.json: /provenance/window_px: {}, {}, {}, {}: no part of the capture's {} x "
        "{} pixels, or between its photosites",
        printable(result_path), window.x, window.y, window.width, window.height, camera.width_px, camera.height_px));
  }
  return zoomed(capture, window);
}

PortraitOptions zoomed(PortraitOptions options, const Window& window, const Camera& camera) {
  const bool turned = options.transposed;
  const Window upright = turned ? Window{window.y, window.x, window.height, window.width} : window;
  for (Face& face : options.faces) face = moved(face, upright, "face");
  if (options.tap) options.tap = moved(*options.tap, upright, "tap");
  if (options.picture) options.picture = cut(*options.picture, window, camera);
  if (options.disparity) {
    const Window part = of_views(window, camera);
    const Window of_maps = turned ? Window{part.y, part.x, part.height, part.width} : part;
    GivenDisparity& given = *options.disparity;
    for (Image* map : {&given.disparity_dp_px, &given.confidence, &given.sigma_dp_px}) {
      *map = cut_pixels(*map, of_maps);
    }
  }
  options.zoom = false;
  return options;
}

}  // namespace dualpixel::pipeline
