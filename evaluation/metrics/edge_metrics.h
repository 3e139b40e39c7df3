#pragma once
#include "capture/image/image.h"
#include "evaluation/metrics/disparity_metrics.h"

/// Position and sharpness of a map's edges, against the true map.
namespace dualpixel::evaluation {

/// Median over the true map's edges of how far the estimate takes from 10 % to 90 % of its own step there, pixels. An
/// edge is a step of the truth by more than `jump` between neighbors along a row or a column that holds within 10 %
/// over the 8 pixels on either side of it. The estimate's step is that between the pixels 16 to either side; where it
/// is under a quarter of the true one, the width counts as 32. 0 where there is no edge.
double edge_width_px(const Image& estimate, const Image& truth, float jump);

/// Boundary F-score (Martin et al. 2004, "Learning to Detect Natural Image Boundaries", with a tolerance in place of
/// matching one to one): harmonic mean of the shares of either side's boundary pixels that lie at most `reach_px` from
/// the other's. A boundary pixel is inside and has one of its four neighbors outside. 1 where neither side has any.
double boundary_f_score(const Mask& estimate, const Mask& truth, int reach_px);

/// 1 where the map differs by more than `jump` from its median over 9 x 9 pixels: hair, leaves, anything thinner
/// than half of that. Taken on every other pixel of the window.
Mask thin_structures(const Image& map, float jump);

}  // namespace dualpixel::evaluation
