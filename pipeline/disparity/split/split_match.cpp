#include "pipeline/disparity/split/split_match.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"
#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/split/split_search.h"

namespace dualpixel::pipeline {

/// Correlation of neighboring tiles' errors: their windows overlap.
constexpr float kWindowShare = 0.9f;

TileDisparity match_by_split(const Image& left, const Image& right, const SplitMatchOptions& options,
                             const LikelihoodMatchOptions& near_focus) {
  using namespace split;
  require_views(left, right);
  check(options);
  check(near_focus);
  if (left.empty()) return {};
  const std::vector<CoarseTile> coarse = search_disparities(left, right, options);
  TileDisparity fine;
  const float limit = options.near_focus_dp_px;
  if (limit > 0) {
    LikelihoodMatchOptions likelihood = near_focus;
    likelihood.range_px = std::min(likelihood.range_px, static_cast<int>(std::ceil(limit)) + 2);
    fine = match_by_likelihood(left, right, likelihood);
  }
  const int columns = (left.width + kTilePx - 1) / kTilePx, rows = (left.height + kTilePx - 1) / kTilePx;
  TileDisparity tiles{Image(columns, rows), Image(columns, rows), Image(columns, rows), Image(columns, rows), kTilePx};
  const auto range = static_cast<float>(options.range_px);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    const CoarseTile& tile = coarse[i];
    const bool invalid = !(tile.variance < range * range);
    if (limit > 0 && std::abs(tile.disparity) < limit && std::abs(fine.disparity_dp_px.data[i]) < limit) {
      tiles.disparity_dp_px.data[i] = fine.disparity_dp_px.data[i];
      tiles.sigma_dp_px.data[i] = fine.sigma_dp_px.data[i];
      tiles.shared.data[i] = fine.shared.data[i];
      tiles.confidence.data[i] = fine.confidence.data[i];
      continue;
    }
    tiles.disparity_dp_px.data[i] = tile.disparity;
    tiles.sigma_dp_px.data[i] = invalid ? range : std::sqrt(tile.variance);
    tiles.shared.data[i] = kWindowShare;
    const float ratio = tile.variance / (options.confident_sigma_dp_px * options.confident_sigma_dp_px);
    tiles.confidence.data[i] = invalid ? 0 : 1 / (1 + ratio);
  }
  return tiles;
}

}  // namespace dualpixel::pipeline
