#include "pipeline/disparity/split/split_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "capture/image/rows.h"
#include "pipeline/disparity/split/split_filters.h"

namespace dualpixel::pipeline::split {
namespace {

/// `to` plus a row of `image` under a separable filter, from x = margin on. `line` is as wide as the image.
void add_filtered(const Image& image, int margin, int y, const SeparableFilter& filter, bool odd,
                  std::vector<float>& line, std::vector<float>& to) {
  const int width = static_cast<int>(to.size());
  const int reach = static_cast<int>(filter.along_x.size()) - 1, reach_y = static_cast<int>(filter.along_y.size()) - 1;
  const int first = margin - reach, last = margin + width + reach;
  const float* at = image.row(y);
  for (int x = first; x < last; ++x) line[x] = filter.along_y[0] * at[x];
  for (int j = 1; j <= reach_y; ++j) {
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

/// Means over tiles, and later over windows, for hypotheses from -range to range: squares of the residual, and products
/// of each residual with the next hypothesis's.
struct Costs {
  std::vector<Image> squares, products;
};

/// Residuals of one row of samples, both signs of one |d|.
struct Residuals {
  std::vector<float> behind, before;
};

/// Adds a row's mean products, tile by tile.
void add_products(const std::vector<float>& a, const std::vector<float>& b, float* tiles, int columns) {
  constexpr float kShare = 1.0f / (kTileSamples * kTileSamples);
  static_assert(kTileSamples == 2);
  for (int column = 0; column < columns; ++column) {
    tiles[column] += kShare * (a[2 * column] * b[2 * column] + a[2 * column + 1] * b[2 * column + 1]);
  }
}

Costs residual_costs(const CoarseViews& views, const std::vector<SplitFilters>& filters) {
  const int range = static_cast<int>(filters.size()) - 1, columns = views.columns;
  Costs costs{std::vector<Image>(2 * range + 1, Image(columns, views.rows)),
              std::vector<Image>(2 * range, Image(columns, views.rows))};
  for_rows(views.rows, [&](int row) {
    const int width = columns * kTileSamples;
    std::vector<float> line(views.sum.width), even(width), odd(width);
    Residuals now{std::vector<float>(width), std::vector<float>(width)}, last = now;
    for (int y = row * kTileSamples; y < (row + 1) * kTileSamples; ++y) {
      for (int d = 0; d <= range; ++d) {
        std::fill(even.begin(), even.end(), 0.0f);
        std::fill(odd.begin(), odd.end(), 0.0f);
        for (const SeparableFilter& term : filters[d].difference) {
          add_filtered(views.difference, views.margin, views.margin + y, term, false, line, even);
        }
        for (const SeparableFilter& term : filters[d].sum) {
          add_filtered(views.sum, views.margin, views.margin + y, term, true, line, odd);
        }
        for (int x = 0; x < width; ++x) {
          now.behind[x] = even[x] + odd[x];
          now.before[x] = even[x] - odd[x];
        }
        add_products(now.behind, now.behind, costs.squares[range + d].row(row), columns);
        if (d > 0) {
          add_products(now.before, now.before, costs.squares[range - d].row(row), columns);
          add_products(last.behind, now.behind, costs.products[range + d - 1].row(row), columns);
          add_products(now.before, last.before, costs.products[range - d].row(row), columns);
        }
        std::swap(now, last);
      }
    }
  });
  return costs;
}

void multiply(Image& image, const Image& by) {
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] *= by.data[i];
}

constexpr float kLeastWeight = 1e-6f;  ///< of a window, below which it holds nothing

/// The window around each tile.
struct Windows {
  Image tile;    ///< a tile's weight in them
  Image weight;  ///< the sum of their tiles'
  Image share;   ///< Kish's effective sample size, over that of a window whose tiles are all usable and weigh alike
  double sigma;  ///< tiles
};

Windows make_windows(const CoarseViews& views, double sigma) {
  Windows windows{views.usable, {}, {}, sigma};
  multiply(windows.tile, views.weight);
  windows.weight = gaussian(windows.tile, sigma, Mirror::even);
  windows.share = windows.tile;
  multiply(windows.share, views.weight);
  windows.share = gaussian(windows.share, sigma, Mirror::even);
  for (std::size_t i = 0; i < windows.share.data.size(); ++i) {
    const float weight = windows.weight.data[i], squares = windows.share.data[i];
    windows.share.data[i] = weight > kLeastWeight ? weight * weight / squares : 0;
  }
  return windows;
}

/// The windows' means of each image.
void sum_over_windows(std::vector<Image>& costs, const Windows& windows) {
  for (Image& cost : costs) {
    multiply(cost, windows.tile);
    cost = gaussian(cost, windows.sigma, Mirror::even);
    for (std::size_t i = 0; i < cost.data.size(); ++i) cost.data[i] /= std::max(windows.weight.data[i], kLeastWeight);
  }
}

float square(float value) { return value * value; }

/// Between two hypotheses the residual is nearly linear: its least square there.
struct Between {
  float position = 0, least = INFINITY;
  float sensitivity = 0;  ///< mean square of the residual's derivative, per DP px
};

Between between(const Costs& costs, int i, std::size_t tile) {
  const float a = costs.squares[i].data[tile], b = costs.squares[i + 1].data[tile], ab = costs.products[i].data[tile];
  const float sensitivity = a - 2 * ab + b;
  if (!(sensitivity > 0)) return {};
  const float t = std::clamp((a - ab) / sensitivity, 0.0f, 1.0f);
  return {static_cast<float>(i) + t, (1 - t) * (1 - t) * a + 2 * t * (1 - t) * ab + t * t * b, sensitivity};
}

/// `share`: Windows::share of the tile; `kernel_error`: of the disparity, what kernels that are not quite the
/// camera's err by.
CoarseTile best_disparity(const Costs& costs, std::size_t tile, float share, float kernel_error) {
  const float samples = 6 * share;          // independent residuals in the window
  constexpr float kLeastResidual = 0.002f;  // of the contrast: what is never explained
  const int count = static_cast<int>(costs.squares.size()), range = count / 2;
  const auto cost = [&](int i) { return costs.squares[i].data[tile]; };
  int best = range;
  for (int d = 1; d <= range; ++d) {
    if (cost(range - d) < cost(best)) best = range - d;
    if (cost(range + d) < cost(best)) best = range + d;
  }
  if (best == 0 || best == count - 1) return {static_cast<float>(best - range), INFINITY};
  const Between low = between(costs, best - 1, tile), high = between(costs, best, tile);
  const Between& found = low.least < high.least ? low : high;
  if (!(found.sensitivity > 0)) return {static_cast<float>(best - range), INFINITY};
  const float position = found.position - static_cast<float>(range), at = found.least;
  const float residual = std::max(at, 0.0f) + kLeastResidual;
  float total = 0, spread = 0;
  for (int i = 0; i < count; ++i) {
    const float likely = std::exp(-0.5f * samples * std::max(cost(i) - at, 0.0f) / residual);
    total += likely;
    if (std::abs(i - best) > 1) spread += likely * square(static_cast<float>(i - range) - position);
  }
  return {position, residual / (samples * found.sensitivity) + spread / total + square(kernel_error * position)};
}

}  // namespace

std::vector<CoarseTile> search_disparities(const Image& left, const Image& right, const SplitMatchOptions& options) {
  const bool known = options.alpha > 0;
  const float alpha = known ? options.alpha : kPhoneAlpha, kernel_error = known ? 0.02f : 0.04f;
  std::vector<SplitFilters> filters(options.range_px + 1);
  tbb::parallel_for(0, options.range_px + 1, [&](int i) {
    const int d = options.range_px - i;  // the largest take longest
    filters[d] = make_filters(d, alpha, {kSamplePx, options.pixel_height, kFilterSmoothing});
  });
  const CoarseViews views = make_coarse_views(left, right, options, filters.back().reach);
  Costs costs = residual_costs(views, filters);
  const Windows windows = make_windows(views, options.window_px / kTilePx);
  for (std::vector<Image>* images : {&costs.squares, &costs.products}) sum_over_windows(*images, windows);
  std::vector<CoarseTile> tiles(views.usable.data.size());
  for_rows(views.rows, [&](int row) {
    for (int column = 0; column < views.columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * views.columns + column;
      tiles[i] = best_disparity(costs, i, windows.share.data[i], kernel_error);
    }
  });
  return tiles;
}

}  // namespace dualpixel::pipeline::split
