#pragma once
#include <vector>

#include "pipeline/disparity/likelihood/options.h"
#include "pipeline/disparity/likelihood/prepared_views.h"

/// The first step of the likelihood matcher: the most likely whole shift of every tile.
namespace dualpixel::pipeline::likelihood {

/// The left view is read `left_shift(s)` to the left, the right view s - left_shift(s) to the right.
inline int left_shift(int shift) { return shift >> 1; }

struct FoundShift {
  int shift = 0;
  float ambiguity = 0;  ///< variance of the shifts that are likely and not next to it, DP px^2
  bool at_end = false;  ///< of the range: what is likelier may lie beyond
};

/// Tile after tile, row after row. A tile's costs are minus twice its log-likelihood, tempered by how well any shift
/// explains it, and joined by those of the tiles around it.
std::vector<FoundShift> search_shifts(const PreparedViews& views, const LikelihoodMatchOptions& options);

}  // namespace dualpixel::pipeline::likelihood
