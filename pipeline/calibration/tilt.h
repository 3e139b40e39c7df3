#pragma once
#include <vector>

#include "capture/capture.h"
#include "pipeline/calibration/target_measurement.h"

namespace dualpixel::pipeline {

/// How far the target of a sweep was from fronto-parallel, in degrees. x > 0: its right side is farther; y > 0: its
/// lower side. The standard errors come from a jackknife over the targets of each focus distance: errors from texture
/// and sensor noise differ from target to target, while a tilt does not. Each target counts by the share of its own
/// error that a line through all leaves it (Wu 1986), or few targets would be given 1.5 times the error that they
/// make. Infinite where fewer than three targets are usable.
struct TargetTilt {
  double x_deg = 0, y_deg = 0;
  double x_error_deg = 0, y_error_deg = 0;
  int degrees_of_freedom = 0;  ///< of the errors: all targets but two of each focus distance
};

/// How many standard errors a tilt must exceed to be as unlikely by chance as three of a normal deviate: Student's t,
/// by Wallace's approximation (1959; 3 % too much at 4 degrees of freedom, 22 % at 2). Errors of a few targets are too
/// small too often.
double significant_errors(int degrees_of_freedom);

/// Mean over the focus distances. A tilted plane's inverse depth is linear in the picture. So a tilt shows in the part
/// of the slope S that is odd about the principal point, while a symmetric lens contributes only to the even part. A
/// lens that is not symmetric looks like a tilt. The two outermost rows and columns of nodes are left out.
TargetTilt estimate_tilt(const Camera& camera, const std::vector<TargetMeasurement>& measurements);

}  // namespace dualpixel::pipeline
