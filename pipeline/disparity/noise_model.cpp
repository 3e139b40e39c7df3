#include "pipeline/disparity/noise_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
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

/// Variance over mean where there is least texture; none where the views are too small.
std::optional<float> shot_at(const Image& left, const Image& right, const Spacing& spacing) {
  std::vector<float> ratios;
  append_noise_ratios(left, spacing, ratios);
  append_noise_ratios(right, spacing, ratios);
  if (ratios.empty()) return {};
  const auto quartile = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 4);
  std::nth_element(ratios.begin(), quartile, ratios.end());
  // In a tile of white noise the lower quartile lies 19 % under the mean (white normal noise through the same filter).
  return std::max(*quartile / 0.81f, kLeastShot);
}

/// Squared differences of neighboring rows over the mean, of those that begin at even and at odd rows.
using ByParity = std::array<double, 2>;

/// Of each tile; `order` 1: of two rows, 2: of three.
void append_row_differences(const Image& view, int order, std::vector<ByParity>& tiles) {
  constexpr int kTile = 8;
  for (int y0 = 0; y0 + kTile + order <= view.height; y0 += kTile) {
    for (int x0 = 1; x0 + kTile < view.width; x0 += kTile) {
      ByParity squares{};
      float sum = 0;
      for (int y = y0; y < y0 + kTile; ++y) {
        for (int x = x0; x < x0 + kTile; ++x) {
          const auto across = [&](int row) { return view.at(x - 1, row) - 2 * view.at(x, row) + view.at(x + 1, row); };
          const float first = across(y + 1) - across(y);
          const float difference = order == 1 ? first : across(y + 2) - across(y + 1) - first;
          squares[y % 2] += difference * difference;
          sum += view.at(x, y);
        }
      }
      if (sum > 0 && std::isfinite(squares[0] + squares[1])) tiles.push_back({squares[0] / sum, squares[1] / sum});
    }
  }
}

/// Whether every other row was made from its neighbors: in the flattest quarter of the tiles, differences that begin at
/// even and at odd rows are not alike. Those of textures are.
bool rows_are_interpolated(const Image& left, const Image& right) {
  constexpr std::size_t kFewestTiles = 2000;  // then like rows differ by 2 % at a standard deviation
  constexpr double kAlike = 0.9;
  for (const int order : {1, 2}) {
    std::vector<ByParity> tiles;
    append_row_differences(left, order, tiles);
    append_row_differences(right, order, tiles);
    if (tiles.size() < kFewestTiles) return false;
    const auto quartile = tiles.begin() + static_cast<std::ptrdiff_t>(tiles.size() / 4);
    std::nth_element(tiles.begin(), quartile, tiles.end(),
                     [](const ByParity& a, const ByParity& b) { return a[0] + a[1] < b[0] + b[1]; });
    ByParity sum{};
    std::for_each(tiles.begin(), quartile, [&](const ByParity& tile) { sum[0] += tile[0], sum[1] += tile[1]; });
    if (std::min(sum[0], sum[1]) < kAlike * std::max(sum[0], sum[1])) return true;
  }
  return false;
}

}  // namespace

ViewNoise estimate_noise(const Image& left, const Image& right) {
  constexpr int kApart = 3;  // rows that share no noise
  const float shot = shot_at(left, right, {1, 1}).value_or(kLeastShot);
  if (!rows_are_interpolated(left, right)) return {shot, kLeastShot};
  const float rows = shot_at(left, right, {1, kApart}).value_or(shot);
  const float columns = shot_at(left, right, {kApart, 1}).value_or(rows);  // narrow views have no columns so far apart
  return {std::clamp(shot * rows / columns, shot, std::max(shot, rows)), kLeastShot};
}

}  // namespace dualpixel::pipeline
