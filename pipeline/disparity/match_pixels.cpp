#include "pipeline/disparity/match_pixels.h"

#include "capture/color_filter_array.h"
#include "capture/image/resample.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::pipeline {

bool is_dense_mosaic(const Capture& capture) {
  return capture.camera.dp_downsample_x * capture.camera.dp_downsample_y == 1 && !capture.frames.front().mosaic.empty();
}

Image green_means(const Image& dense, const std::string& cfa) {
  const bool green_first = value_named(kColorFilterArrays, cfa, "cfa").color(0, 0) == 1;
  Image means(dense.width / 2, dense.height / 2);
  for (int y = 0; y < means.height; ++y) {
    for (int x = 0; x < means.width; ++x) {
      const int u = 2 * x + (green_first ? 0 : 1);
      means.at(x, y) = 0.5f * (dense.at(u, 2 * y) + dense.at(u ^ 1, 2 * y + 1));
    }
  }
  return means;
}

ViewSensor sensor_of_green_means(const ViewSensor& dense) {
  ViewSensor sensor = dense;
  if (sensor.noise) sensor.noise = ViewNoise{dense.noise->shot / 2, dense.noise->read / 2};
  for (SkewCurve& curve : sensor.skew.nodes) curve = in_larger_pixels(curve, 2);
  return sensor;
}

PixelDisparity match_pixels(const Capture& capture, const Image& left, const Image& right, const ViewSensor& sensor,
                            const Matcher& matcher, const MatcherOptions& options, const UpsampleOptions& upsampling) {
  const ViewSensor own = of_camera(sensor, capture.camera);
  if (!is_dense_mosaic(capture)) {
    return upsample_tiles(matcher.match(left, right, own, options), left.width, left.height, upsampling);
  }
  constexpr int kSide = 2;
  const std::string& cfa = capture.camera.cfa;
  const Image small_left = green_means(left, cfa), small_right = green_means(right, cfa);
  const auto tiles = matcher.match(small_left, small_right, sensor_of_green_means(own), options);
  PixelDisparity found = upsample_tiles(tiles, small_left.width, small_left.height, upsampling);
  for (Image* map : {&found.disparity_dp_px, &found.sigma_dp_px}) {
    for (float& value : map->data) value *= kSide;
  }
  for (Image* map : {&found.disparity_dp_px, &found.confidence, &found.sigma_dp_px}) {
    if (!map->empty()) *map = resize_bilinear(*map, left.width, left.height);
  }
  return found;
}

}  // namespace dualpixel::pipeline
