#include "pipeline/disparity/likelihood/likelihood_match.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"
#include "pipeline/disparity/likelihood/prepared_views.h"
#include "pipeline/disparity/likelihood/refine_shift.h"
#include "pipeline/disparity/likelihood/shift_search.h"

namespace dualpixel::pipeline {

/// Correlation of neighboring tiles' errors other than noise, measured on the portrait scene.
constexpr float kModelShare = 0.2f;

TileDisparity match_by_likelihood(const Image& left, const Image& right, const LikelihoodMatchOptions& options) {
  using namespace likelihood;
  require_views(left, right);
  check(options);
  if (left.empty()) return {};
  const ViewNoise noise = options.noise ? *options.noise : estimate_noise(left, right);
  const int range = options.range_px;
  const int margin = range / 2 + 1 + 8;  // half the range, a step of refinement, the taps
  const PreparedViews views = prepare_views(left, right, margin, noise, options.clipped * options.white);
  const int columns = views.columns, rows = views.rows;
  const std::vector<FoundShift> found = search_shifts(views, options);

  // What is left of the shading: means of the views over 5 x 5 tiles, shifted to match.
  Image difference(columns, rows), level(columns, rows);
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const int shift = found[static_cast<std::size_t>(row) * columns + column].shift;
      const int a = left_shift(shift), b = shift - a;
      Columns sums{}, levels{};
      for (int y = row * kTile; y < (row + 1) * kTile; ++y) {
        const float* ls = views.left.smooth.row(y) + margin + column * kTile - a;
        const float* rs = views.right.smooth.row(y) + margin + column * kTile + b;
        for (int i = 0; i < kTile; ++i) {
          sums[i] += rs[i] - ls[i];
          levels[i] += 0.5f * (rs[i] + ls[i]);
        }
      }
      difference.at(column, row) = sum(sums) / (kTile * kTile);
      level.at(column, row) = sum(levels) / (kTile * kTile);
    }
  });
  const Image local_difference = box_mean(difference, 2), local_level = box_mean(level, 2);

  const float limit = static_cast<float>(range);
  std::vector<RefinedTile> refined(found.size());
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * columns + column;
      const FoundShift& tile = found[i];
      const float signal = std::max(level.at(column, row), 1e-4f);
      const float offset = local_difference.at(column, row) / std::max(local_level.at(column, row), 1e-4f) * signal;
      const SkewCurve skew = options.skew.at((column + 0.5) * kTile / left.width, (row + 0.5) * kTile / left.height);
      refined[i] = refine_shift(views, column * kTile, row * kTile, static_cast<float>(tile.shift),
                                {offset, options.offset * signal}, skew, 1.5f);
      refined[i].disparity = std::clamp(refined[i].disparity, -limit, limit);
      refined[i].model += tile.ambiguity;
      if (tile.at_end) refined[i].noise = INFINITY;
    }
  });

  std::vector<RefinedTile> smooth(refined.size());
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      smooth[static_cast<std::size_t>(row) * columns + column] =
          pooled_with_neighbors(refined, columns, rows, column, row);
    }
  });
  TileDisparity tiles{Image(columns, rows), Image(columns, rows), Image(columns, rows), Image(columns, rows), kTile};
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const float variance = predicted_variance(smooth, columns, rows, column, row);
      const bool invalid = !(variance < square(limit));
      const RefinedTile& tile = smooth[static_cast<std::size_t>(row) * columns + column];
      tiles.disparity_dp_px.at(column, row) = tile.disparity;
      const float pooled = pooled_share(tile.disparity);
      tiles.shared.at(column, row) = invalid ? 1 : pooled + (1 - pooled) * kModelShare * (1 - tile.noise / variance);
      tiles.sigma_dp_px.at(column, row) = invalid ? limit : std::sqrt(variance);
      tiles.confidence.at(column, row) = invalid ? 0 : 1 / (1 + variance / square(options.confident_sigma_dp_px));
    }
  });
  return tiles;
}

}  // namespace dualpixel::pipeline
