#pragma once
#include <cmath>
#include <vector>

#include "pipeline/disparity/kernel_skew.h"
#include "pipeline/disparity/likelihood/prepared_views.h"

/// The second step of the likelihood matcher: refines a whole shift to a fraction of a pixel, predicts the error's
/// variance, and combines neighboring tiles.
namespace dualpixel::pipeline::likelihood {

struct RefinedTile {
  float disparity = 0;     ///< DP px
  float noise = INFINITY;  ///< variance of the error due to the views' noise; independent between tiles
  float model = 0;         ///< variance due to differences that no shift explains; partly shared by neighbors
};

/// How much brighter the right view is, with its standard deviation.
struct ViewOffset {
  float mean = 0, sigma = 0;
};

/// Gauss-Newton from `start`, at most `farthest` away from it, with both views interpolated symmetrically, and with the
/// skew of their kernels taken out. A tile without information gets infinite noise.
RefinedTile refine_shift(const PreparedViews& views, int x0, int y0, float start, const ViewOffset& offset,
                         const SkewCurve& skew, float farthest);

/// The weighted mean over those tiles around that agree; the weight's reach grows with the shift. Where blur is wider
/// than a tile, neighboring tiles see much of the same light through other parts of the mirrored kernels, and their
/// errors differ, so that the mean has less error.
RefinedTile pooled_with_neighbors(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row);

/// Correlation of two neighboring tiles' errors after pooling: that of two means whose weights overlap.
float pooled_share(float disparity);

/// Variance of disparity over the 3 x 3 tiles around, beyond what their errors explain, where that is three standard
/// deviations or more; else 0. Slopes, edges, foliage.
float roughness(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row);

/// The predicted variance of a tile's error: its own variance, that which mirrored kernels and rough surfaces add to
/// every tile, and that due to disagreement with its neighbors. A visible surface extends into at least half of the
/// tiles around. So a tile that differs from all of them shows a highlight, a structure narrower than its blur, or a
/// mismatch, and its error may be as large as the difference.
float predicted_variance(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row);

}  // namespace dualpixel::pipeline::likelihood
