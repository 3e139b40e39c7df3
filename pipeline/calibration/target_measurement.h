#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline {

struct FlowOptions;

/// Measured on one capture of the target.
struct TargetMeasurement {
  double focus_distance_m = 0;   ///< infinity is allowed
  double target_distance_m = 0;  ///< planar depth on the axis
  Image disparity_dp_px;         ///< at the nodes
  Image usable;                  ///< 1 where the views matched, 0 elsewhere
};

/// `left` and `right` are the linear views. A node's disparity is that of the quadratic surface that fits the flow
/// best as far as the nodes around it, with weights that fall to 0 there: a lens of many aspheres curves its field
/// within three nodes, which a plane would flatten. It is usable where the matched views' mismatch there, by the same
/// weights, is at most 0.5.
TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m);
TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m, const FlowOptions& options);

}  // namespace dualpixel::pipeline
