#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/image/image.h"
#include "capture/image/rows.h"
#include "pipeline/disparity/noise_model.h"

namespace dualpixel::pipeline {

/// Cramer-Rao bound: no unbiased estimate of a tile's shift has a smaller standard deviation, DP px, than
///     1 / sqrt(sum over the tile of I'^2 / (2 (shot * I + read)))
/// where I is the noise-free view, the same in both views but for the shift, and I' its derivative along x. One pixel
/// for each tile, ceil(size / tile_px) of them; infinite where the view is constant.
inline Image shift_bound_dp_px(const Image& noise_free_view, const ViewNoise& noise, int tile_px = 8) {
  const int width = noise_free_view.width, height = noise_free_view.height;
  constexpr int kReach = 12;  // derivative of a sinc under a Hann window: right within 0.3 % up to 0.4 cycles a pixel
  double slope[kReach + 1] = {};
  for (int k = 1; k <= kReach; ++k) {
    const double window = 0.5 + 0.5 * std::cos(std::numbers::pi * k / (kReach + 1));
    slope[k] = (k % 2 == 1 ? 1.0 : -1.0) / k * window;
  }
  Image bound((width + tile_px - 1) / tile_px, (height + tile_px - 1) / tile_px);
  for_rows(bound.height, [&](int row) {
    for (int column = 0; column < bound.width; ++column) {
      double information = 0;
      for (int y = row * tile_px; y < std::min((row + 1) * tile_px, height); ++y) {
        const float* line = noise_free_view.row(y);
        for (int x = column * tile_px; x < std::min((column + 1) * tile_px, width); ++x) {
          double derivative = 0;
          for (int k = 1; k <= kReach; ++k) {
            derivative += slope[k] * (line[std::min(x + k, width - 1)] - line[std::max(x - k, 0)]);
          }
          information += derivative * derivative / (2 * (noise.shot * std::max(line[x], 0.0f) + noise.read));
        }
      }
      bound.at(column, row) =
          information > 0 ? static_cast<float>(1 / std::sqrt(information)) : std::numeric_limits<float>::infinity();
    }
  });
  return bound;
}

}  // namespace dualpixel::pipeline
