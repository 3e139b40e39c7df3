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

/// `left` and `right` are the linear views. A node's disparity is the value there of a quadratic surface that is fitted
/// to the flow around it, with weights that fall to 0 at the neighboring nodes. (A plane would flatten the field of a
/// lens with many aspheres, which curves within three nodes.) A node is usable where the mean mismatch of the matched
/// views, by the same weights, is at most 0.5.
TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m);
TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m, const FlowOptions& options);

}  // namespace dualpixel::pipeline
