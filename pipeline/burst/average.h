#pragma once
#include <vector>

#include "capture/capture.h"
#include "capture/image.h"

/// The burst as one picture: the plain mean of its frames, which is right where nothing moves.
namespace dualpixel::pipeline {

/// Signals normalised as (DN - black) / (white - black): 0 is black, 1 is clipped; noise may go below 0.
struct MergedBurst {
  Image mosaic;  ///< full sensor size; empty where the frames hold no mosaic
  Image left;    ///< DP size
  Image right;
};

/// `frames` holds at least one; all are of one size.
MergedBurst average_burst(const std::vector<Frame>& frames, const Exposure& exposure);

}  // namespace dualpixel::pipeline
