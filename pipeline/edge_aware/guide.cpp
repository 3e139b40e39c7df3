#include "pipeline/edge_aware/guide.h"

#include <algorithm>
#include <cmath>

#include "capture/image/rows.h"

namespace dualpixel::pipeline {
namespace {

/// 0..1; also where the value is not a number.
float clipped(float value) { return value > 0 ? std::min(value, 1.0f) : 0.0f; }

}  // namespace

float guide_gain(const Image& linear_rgb) {
  double sum = 0;
  for (const float value : linear_rgb.data) sum += clipped(value);
  const double mean = sum / static_cast<double>(linear_rgb.data.size());
  return mean > 0 ? static_cast<float>(std::max(0.2 / mean, 1.0)) : 1.0f;
}

Image encode_guide(const Image& linear_rgb, float gain) {
  Image guide(linear_rgb.width, linear_rgb.height, linear_rgb.channels);
  for_rows(guide.height, [&](int y) {
    const float* from = linear_rgb.row(y);
    float* to = guide.row(y);
    for (int i = 0; i < guide.width * guide.channels; ++i) to[i] = 255 * std::sqrt(clipped(gain * from[i]));
  });
  return guide;
}

}  // namespace dualpixel::pipeline
