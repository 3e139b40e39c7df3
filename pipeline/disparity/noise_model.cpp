#include "pipeline/disparity/noise_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kLeastShot = 1e-7f;  // far below that of any sensor; keeps weights finite

void append_noise_ratios(const Image& view, std::vector<float>& ratios) {
  constexpr int kTile = 8;
  for (int y0 = 1; y0 + kTile < view.height; y0 += kTile) {
    for (int x0 = 1; x0 + kTile < view.width; x0 += kTile) {
      float sum = 0, squares = 0;
      for (int y = y0; y < y0 + kTile; ++y) {
        const float* above = view.row(y - 1);
        const float* at = view.row(y);
        const float* below = view.row(y + 1);
        for (int x = x0; x < x0 + kTile; ++x) {
          const auto across = [x](const float* row) { return row[x - 1] - 2 * row[x] + row[x + 1]; };
          const float difference = across(above) - 2 * across(at) + across(below);
          sum += at[x];
          squares += difference * difference;
        }
      }
      const float ratio = squares / (36 * sum);  // 36: the squares of the filter's weights
      if (sum > 0 && std::isfinite(ratio)) ratios.push_back(ratio);
    }
  }
}

}  // namespace

ViewNoise estimate_noise(const Image& left, const Image& right) {
  std::vector<float> ratios;
  append_noise_ratios(left, ratios);
  append_noise_ratios(right, ratios);
  if (ratios.empty()) return {kLeastShot, kLeastShot};
  const auto quartile = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 4);
  std::nth_element(ratios.begin(), quartile, ratios.end());
  // In a tile of white noise the lower quartile lies 19 % under the mean (white normal noise through the same filter).
  return {std::max(*quartile / 0.81f, kLeastShot), kLeastShot};
}

Image shift_bound_dp_px(const Image& noise_free_view, const ViewNoise& noise, int tile_px) {
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
