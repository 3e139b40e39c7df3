#pragma once
#include "capture/capture.h"
#include "pipeline/calibration/correction.h"
#include "simulator/lens/disparity_field.h"

namespace dualpixel::evaluation {

/// The disparity of a plane parallel to the sensor, DP px: the traced lens's own, after a correction where there is
/// one. A quarter of the views' width, half of their height.
Image plane_disparity(const simulator::DisparityField& field, const Camera& camera, double depth_m,
                      const pipeline::Correction* correction = nullptr);

/// Standard deviation over the inner 90 % of a map of the field.
double deviation_inside(const Image& map);

}  // namespace dualpixel::evaluation
