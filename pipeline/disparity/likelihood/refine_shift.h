#pragma once
#include <cmath>
#include <vector>

#include "pipeline/disparity/likelihood/prepared_views.h"

/// The second step of the likelihood matcher: from a whole shift to a fraction of a pixel and its variance, and what
/// tiles tell about each other.
namespace dualpixel::pipeline::likelihood {

struct RefinedTile {
  float disparity = 0;     ///< DP px
  float noise = INFINITY;  ///< variance of the error that the views' noise makes: each tile's own
  float model = 0;         ///< and of that from what no shift explains: partly common to neighbors
};

/// Gauss-Newton from `start`, both views interpolated symmetrically, at most `farthest` away. `offset`, with its
/// standard deviation, is what the right view is brighter by. A tile without information comes back with infinite
/// noise.
RefinedTile refine_shift(const PreparedViews& views, int x0, int y0, float start, float offset, float offset_sigma,
                         float farthest);

/// Where blur is wider than a tile, the tiles around see much of the same light through other parts of the mirrored
/// kernels, and err differently: the mean over those that agree, by a weight that reaches as far as the shift is large.
RefinedTile pooled_with_neighbors(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row);

/// Correlation of two neighboring tiles' errors after pooling: that of means under its weights, as far as they reach.
float pooled_share(float disparity);

/// Variance of disparity over the 3 x 3 tiles around, beyond what their errors explain, where that is three standard
/// deviations or more; else 0. Slopes, edges, foliage.
float roughness(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row);

/// Variance of the error as it is predicted: the tile's own, what mirrored kernels and rough surfaces do to any, and
/// what its neighbors raise against it. A surface that is seen goes on in at least one half of the tiles around; a
/// tile that differs from all of them shows a highlight, a structure narrower than its blur, or a mistake, and may be
/// as wrong as it is different.
float predicted_variance(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row);

}  // namespace dualpixel::pipeline::likelihood
