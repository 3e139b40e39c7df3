#include "pipeline/segmentation/fit.h"

#include <algorithm>
#include <cmath>

#include "capture/image/display.h"
#include "capture/image/resample.h"
#include "capture/image/rows.h"

namespace dualpixel::pipeline {

Image fitted(const Image& linear, int longer_side_px) {
  Image clipped(linear.width, linear.height, 3);
  for_rows(linear.height, [&](int y) {
    for (int x = 0; x < linear.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = linear.at(x, y, linear.channels == 1 ? 0 : c);
        clipped.at(x, y, c) = value >= 0 ? std::min(value, 1.F) : 0.F;
      }
    }
  });
  const double scale = static_cast<double>(longer_side_px) / std::max(linear.width, linear.height);
  const int width = std::max(1, static_cast<int>(std::lround(scale * linear.width)));
  const int height = std::max(1, static_cast<int>(std::lround(scale * linear.height)));
  return scale < 1 ? resize_area(clipped, width, height) : resize_bilinear(clipped, width, height);
}

Framed framed(const Image& linear, int side_px, int channels) {
  const Image small = encode_for_display(fitted(linear, side_px));
  Framed result{Image(side_px, side_px, channels, -0.5F), (side_px - small.width) / 2, (side_px - small.height) / 2,
                small.width, small.height};
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) result.square.at(result.left + x, result.top + y, c) = small.at(x, y, c) - 0.5F;
    }
  }
  return result;
}

}  // namespace dualpixel::pipeline
