#include "pipeline/disparity/split/split_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "capture/image/rows.h"
#include "pipeline/disparity/split/split_filters.h"

namespace dualpixel::pipeline::split {
namespace {

/// `to` plus a row of `image` under a separable filter, from x = margin on. `line` is as wide as the image.
void add_filtered(const Image& image, int margin, int y, int reach, const SeparableFilter& filter, bool odd,
                  std::vector<float>& line, std::vector<float>& to) {
  const int width = static_cast<int>(to.size());
  const int first = margin - reach, last = margin + width + reach;
  const float* at = image.row(y);
  for (int x = first; x < last; ++x) line[x] = filter.along_y[0] * at[x];
  for (int j = 1; j <= reach; ++j) {
    const float tap = filter.along_y[j];
    const float *above = image.row(y - j), *below = image.row(y + j);
    for (int x = first; x < last; ++x) line[x] += tap * (above[x] + below[x]);
  }
  const float* middle = line.data() + margin;
  float* out = to.data();
  if (!odd) {
    for (int x = 0; x < width; ++x) out[x] += filter.along_x[0] * middle[x];
  }
  for (int i = 1; i <= reach; ++i) {
    const float tap = filter.along_x[i], other = odd ? -tap : tap;
    for (int x = 0; x < width; ++x) out[x] += tap * middle[x - i] + other * middle[x + i];
  }
}

/// Mean squares of every tile's residuals: one image a hypothesis, from -range to range.
std::vector<Image> squared_residuals(const CoarseViews& views, const std::vector<SplitFilters>& filters) {
  const int range = static_cast<int>(filters.size()) - 1;
  std::vector<Image> costs(2 * range + 1, Image(views.columns, views.rows));
  for_rows(views.rows, [&](int row) {
    const int width = views.columns * kTileSamples;
    std::vector<float> line(views.sum.width), even(width), odd(width);
    for (int d = 0; d <= range; ++d) {
      for (int y = row * kTileSamples; y < (row + 1) * kTileSamples; ++y) {
        std::fill(even.begin(), even.end(), 0.0f);
        std::fill(odd.begin(), odd.end(), 0.0f);
        const int reach = filters[d].reach;
        for (const SeparableFilter& term : filters[d].difference) {
          add_filtered(views.difference, views.margin, views.margin + y, reach, term, false, line, even);
        }
        if (d > 0) {
          for (const SeparableFilter& term : filters[d].sum) {
            add_filtered(views.sum, views.margin, views.margin + y, reach, term, true, line, odd);
          }
        }
        float *behind = costs[range + d].row(row), *before = costs[range - d].row(row);
        constexpr float kShare = 1.0f / (kTileSamples * kTileSamples);
        for (int column = 0; column < views.columns; ++column) {
          for (int i = column * kTileSamples; i < (column + 1) * kTileSamples; ++i) {
            const float plus = even[i] + odd[i], minus = even[i] - odd[i];
            behind[column] += kShare * plus * plus;
            if (d > 0) before[column] += kShare * minus * minus;
          }
        }
      }
    }
  });
  return costs;
}

/// The window's means of each image, tiles weighed by what of them is usable.
void sum_over_windows(std::vector<Image>& costs, const Image& usable, double sigma) {
  Image total = gaussian(usable, sigma);
  for (float& value : total.data) value = 1 / std::max(value, 1e-6f);
  for (Image& cost : costs) {
    for (std::size_t i = 0; i < cost.data.size(); ++i) cost.data[i] *= usable.data[i];
    cost = gaussian(cost, sigma);
    for (std::size_t i = 0; i < cost.data.size(); ++i) cost.data[i] *= total.data[i];
  }
}

float square(float value) { return value * value; }

CoarseTile best_disparity(const std::vector<Image>& costs, std::size_t tile) {
  constexpr float kSamples = 6;         // independent residuals in a window
  constexpr float kLeastResidual = 0.002f;  // of the contrast: what is never explained
  constexpr float kKernelError = 0.04f;  // of the disparity: what an unknown split's kernels err by
  const int count = static_cast<int>(costs.size()), range = count / 2;
  const auto cost = [&](int i) { return costs[i].data[tile]; };
  int best = range;
  for (int d = 1; d <= range; ++d) {
    if (cost(range - d) < cost(best)) best = range - d;
    if (cost(range + d) < cost(best)) best = range + d;
  }
  if (best == 0 || best == count - 1) return {static_cast<float>(best - range), INFINITY};
  const float before = cost(best - 1), at = cost(best), after = cost(best + 1);
  const float curvature = before - 2 * at + after;
  if (!(curvature > 0)) return {static_cast<float>(best - range), INFINITY};
  const float offset = 0.5f * (before - after) / curvature;
  const float residual = std::max(at - 0.25f * (before - after) * offset, 0.0f) + kLeastResidual;
  const float position = static_cast<float>(best - range) + offset;
  float total = 0, spread = 0;
  for (int i = 0; i < count; ++i) {
    const float likely = std::exp(-0.5f * kSamples * (cost(i) - at) / residual);
    total += likely;
    if (std::abs(i - best) > 1) spread += likely * square(static_cast<float>(i - range) - position);
  }
  return {position, 2 * residual / (kSamples * curvature) + spread / total + square(kKernelError * position)};
}

}  // namespace

std::vector<CoarseTile> search_disparities(const Image& left, const Image& right, const SplitMatchOptions& options) {
  std::vector<SplitFilters> filters;
  for (int d = 0; d <= options.range_px; ++d) {
    filters.push_back(make_filters(d, options.alpha, kSamplePx, kFilterSmoothing));
  }
  const CoarseViews views = make_coarse_views(left, right, options, filters.back().reach);
  std::vector<Image> costs = squared_residuals(views, filters);
  sum_over_windows(costs, views.usable, options.window_px / kTilePx);
  std::vector<CoarseTile> tiles(views.usable.data.size());
  for_rows(views.rows, [&](int row) {
    for (int column = 0; column < views.columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * views.columns + column;
      tiles[i] = best_disparity(costs, i);
    }
  });
  return tiles;
}

}  // namespace dualpixel::pipeline::split
