#include "pipeline/disparity/noise_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dualpixel::pipeline {
namespace {

constexpr float kLeastShot = 1e-7f;  // far below that of any sensor; keeps weights finite

/// Of the second differences of pixels so many columns and rows apart.
struct Spacing {
  int columns = 1, rows = 1;
};

void append_noise_ratios(const Image& view, const Spacing& spacing, std::vector<float>& ratios) {
  constexpr int kTile = 8;
  const int dx = spacing.columns, dy = spacing.rows;
  for (int y0 = dy; y0 + kTile + dy <= view.height; y0 += kTile) {
    for (int x0 = dx; x0 + kTile + dx <= view.width; x0 += kTile) {
      float sum = 0, squares = 0;
      for (int y = y0; y < y0 + kTile; ++y) {
        const float* above = view.row(y - dy);
        const float* at = view.row(y);
        const float* below = view.row(y + dy);
        for (int x = x0; x < x0 + kTile; ++x) {
          const auto across = [x, dx](const float* row) { return row[x - dx] - 2 * row[x] + row[x + dx]; };
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

/// Variance over mean where there is least texture.
float shot_at(const Image& left, const Image& right, const Spacing& spacing) {
  std::vector<float> ratios;
  append_noise_ratios(left, spacing, ratios);
  append_noise_ratios(right, spacing, ratios);
  if (ratios.empty()) return kLeastShot;
  const auto quartile = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 4);
  std::nth_element(ratios.begin(), quartile, ratios.end());
  // In a tile of white noise the lower quartile lies 19 % under the mean (white normal noise through the same filter).
  return std::max(*quartile / 0.81f, kLeastShot);
}

}  // namespace

ViewNoise estimate_noise(const Image& left, const Image& right) {
  constexpr int kApart = 3;              // rows that share no noise
  constexpr float kInterpolated = 2.5f;  // texture alone makes no such difference between rows and columns
  const float shot = shot_at(left, right, {1, 1});
  const float rows = shot_at(left, right, {1, kApart}) / shot_at(left, right, {kApart, 1});
  return {rows > kInterpolated ? rows * shot : shot, kLeastShot};
}

}  // namespace dualpixel::pipeline
