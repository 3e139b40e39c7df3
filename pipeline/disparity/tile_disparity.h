#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// What a matcher finds: one pixel for each tile of the left view, ceil(size / tile_px) of them along each axis.
/// Disparity d, in DP px, has right(x + d) = left(x).
struct TileDisparity {
  Image disparity_dp_px;  ///< always finite, within +- the matcher's range
  Image confidence;       ///< 0..1
  Image sigma_dp_px;      ///< predicted standard deviation of the error; empty where the matcher predicts none
  Image shared;           ///< share of sigma^2, 0..1, that neighboring tiles' errors have in common; empty as sigma is
  int tile_px = 8;        ///< side of a tile, DP px
};

/// Throws InputError where the views of a matcher differ in size or have more than one channel.
void require_views(const Image& left, const Image& right);

}  // namespace dualpixel::pipeline
