#include "pipeline/disparity/noise_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

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

}  // namespace dualpixel::pipeline
