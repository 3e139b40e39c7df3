#pragma once
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// Disparity of every tile by brute force (Wadhwa et al. 2018, section 4.1).
namespace dualpixel::pipeline {

struct TileDisparity;

struct MatchOptions {
  int tile_px = 8;   ///< side of the tiles, DP pixels; they do not overlap (section 4.1: 8 x 8)
  int range_px = 3;  ///< shifts from -range to range are tried, DP pixels (section 4.1: 3)

  // Confidence: the paper names the four heuristics but no formula. These are ours; the views have unit local variance.
  float ssd_scale = 0.2f;        ///< mean squared difference at which confidence falls to 1/e; 2: unrelated views
  float ssd_floor = 0.01f;       ///< mean squared difference that even a perfect match is taken to have
  float deviation_dp_px = 0.3f;  ///< expected error, DP px, at which confidence halves
  float second_minimum = 0.8f;   ///< best cost over the second best at which confidence begins to fall
  float agreement_dp_px = 0.3f;  ///< difference from a neighboring tile at which its support falls to 1/e, DP px
};

OptionFields fields(MatchOptions& options);

/// Throws InputError where a value is out of its range.
void check(const MatchOptions& options);

/// `left` and `right` are normalized views (normalize.h) of one size. Returns d with right(x + d) = left(x): for each
/// tile of the left view, the minimum of the parabola through the least sum of squared differences and its neighbors.
///
/// Near the left and right border a tile shrinks to the pixels whose whole search range lies inside the right view.
/// Confidence is 0 where nothing of it is left, where the costs have no unique minimum, or where the least cost lies at
/// an end of the range: the true minimum may be beyond. Elsewhere it is the product of
///   - exp(-q / ssd_scale), q the mean squared difference at the parabola's minimum;
///   - 1 / (1 + v / deviation^2), v = (q + ssd_floor) / (pixels * g2) the variance of a least-squares shift estimate,
///     g2 the mean squared horizontal gradient minus q / 4, the part that is due to noise;
///   - ((1 - q/q2) / (1 - second_minimum))^2, at most 1, q2 the least cost more than one pixel away;
///   - the share of the eight neighbors' confidence that agrees, each by exp(-(difference / agreement)^2).
///
/// Throws InputError where the views differ in size or have more than one channel, and where an option is out of range.
TileDisparity match_tiles(const Image& left, const Image& right, const MatchOptions& options = {});

}  // namespace dualpixel::pipeline
