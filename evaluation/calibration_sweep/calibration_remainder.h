#pragma once
#include <string>
#include <vector>

#include "simulator/scene_file.h"

/// What a calibration leaves of a lens's aberrations, by cause.
namespace dualpixel::evaluation {

struct CalibrationRemainder {
  std::string cause;
  /// Deviation of a plane's disparity over the inner 90 % of the field, after correction; NaN: could not be measured.
  double sigma_dp_px = 0;
};

/// Of a plane at `plane_m`, the camera at the scene's focus distance. The first four are cumulative:
///   grid      lines traced at the 21 x 15 nodes, at that focus distance: what bicubic interpolation leaves
///   focus     the same traced at the two focus distances around, of a sweep's twenty
///   targets   measured on eight simulated targets at each of the two
///   noise     these photographed at ISO 400
///   by hand   as "noise" with three targets at each of five focus distances from infinity to 0.2 m, tilted by one
///             degree: fifteen photographs
///   matching  corrected as in "targets", but what the default matcher finds in views of a textured plane at ISO 100:
///             means over squares of 16 x 16 DP px. NaN for a plane at infinity, and for pictures of fewer than ten
///             such squares along a side
/// All but the last judge the traced lens's own disparity. Throws InputError where the camera cannot be calibrated.
std::vector<CalibrationRemainder> measure_remainders(const simulator::Simulation& simulation, double plane_m);

}  // namespace dualpixel::evaluation
