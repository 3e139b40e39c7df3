#pragma once
#include <vector>

#include "pipeline/disparity/split/coarse_views.h"

/// Which disparity's kernels explain a tile and its surroundings.
namespace dualpixel::pipeline::split {

struct CoarseTile {
  float disparity = 0;  ///< DP px
  float variance = 0;   ///< of its error, DP px^2; infinite where nothing can be said
};

/// Tile after tile, row after row.
std::vector<CoarseTile> search_disparities(const Image& left, const Image& right, const SplitMatchOptions& options);

}  // namespace dualpixel::pipeline::split
