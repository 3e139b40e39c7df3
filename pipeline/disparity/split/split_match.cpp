#include "pipeline/disparity/split/split_match.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"
#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/split/split_search.h"

namespace dualpixel::pipeline {
namespace {

/// Correlation of neighboring tiles' errors: their windows overlap.
constexpr float kWindowShare = 0.9f;
/// Disparities that lie farther apart than so many standard deviations are taken to differ.
constexpr float kSureDeviations = 2;

struct Answer {
  float disparity = 0, deviation = 0, shared = 0;
};

/// Whether the likelihood matcher finds what step 3 does, beyond the limit on the same side, and excludes the focus.
bool both_are_far(const Answer& far, const Answer& fine, float limit) {
  const float distance = std::abs(fine.disparity);
  return distance >= limit && kSureDeviations * fine.deviation < distance && far.disparity * fine.disparity > 0 &&
         std::abs(far.disparity - fine.disparity) < kSureDeviations * std::hypot(far.deviation, fine.deviation);
}

/// Step 4. `fine`: the likelihood matcher's, of infinite deviation where it has none.
Answer choose(const split::CoarseTile& coarse, const Answer& fine, float limit) {
  const Answer far{coarse.disparity, std::sqrt(coarse.variance), kWindowShare};
  const float reach = kSureDeviations * far.deviation, apart = std::abs(far.disparity - fine.disparity);
  const bool fine_is_near = std::isfinite(fine.deviation) && std::abs(fine.disparity) < limit;
  if (std::abs(far.disparity) < limit) {
    if (fine_is_near) return fine;
    const bool fine_is_sure = kSureDeviations * fine.deviation < std::max(apart, std::abs(fine.disparity));
    if (std::isfinite(far.deviation) && fine_is_sure) {  // beside a depth edge
      return {fine.disparity, std::hypot(fine.deviation, apart / 2), fine.shared};
    }
    return {far.disparity, std::max(far.deviation, fine.deviation), far.shared};
  }
  const bool may_be_near = std::isfinite(far.deviation) && std::abs(far.disparity) - reach < limit;
  if (!may_be_near || both_are_far(far, fine, limit)) return far;
  if (fine_is_near && apart < reach) return {fine.disparity, std::hypot(fine.deviation, apart), fine.shared};
  return {far.disparity, std::hypot(far.deviation, far.disparity), far.shared};
}

}  // namespace

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
    Answer answer{coarse[i].disparity, std::sqrt(coarse[i].variance), kWindowShare};
    if (limit > 0) {
      const float deviation = fine.confidence.data[i] > 0 ? fine.sigma_dp_px.data[i] : INFINITY;
      answer = choose(coarse[i], {fine.disparity_dp_px.data[i], deviation, fine.shared.data[i]}, limit);
    }
    const bool known = answer.deviation < range;  // not where it is not finite
    const float ratio = answer.deviation / options.confident_sigma_dp_px;
    tiles.disparity_dp_px.data[i] = answer.disparity;
    tiles.sigma_dp_px.data[i] = known ? answer.deviation : range;
    tiles.shared.data[i] = answer.shared;
    tiles.confidence.data[i] = known ? 1 / (1 + ratio * ratio) : 0;
  }
  return tiles;
}

}  // namespace dualpixel::pipeline
