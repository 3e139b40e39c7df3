#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// Measured on one capture of the target.
struct TargetMeasurement {
  double focus_distance_m = 0;   ///< infinity is allowed
  double target_distance_m = 0;  ///< planar depth on the axis
  Image disparity_dp_px;         ///< at the nodes
  Image usable;                  ///< 1 where the views matched, 0 elsewhere
};

}  // namespace dualpixel::pipeline
