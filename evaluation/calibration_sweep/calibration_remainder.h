#pragma once
#include <string>
#include <vector>

#include "simulator/scene_file.h"

/// What a calibration leaves of a lens's aberrations, by cause.
namespace dualpixel::evaluation {

/// One way to calibrate or to judge; each but the first adds a cause of error to what precedes it.
struct CalibrationRemainder {
  std::string cause;
  double sigma_dp_px = 0;  ///< deviation of a plane's disparity over the inner 90 % of the field, after correction
};

/// Of a plane at `plane_m`, the camera at the scene's focus distance:
///   grid           lines traced at the 21 x 15 nodes, at that focus distance: what bicubic interpolation leaves
///   focus          the same traced at the two focus distances around, of a sweep's twenty
///   targets        measured on simulated targets: their texture, and kernels that are no shifts of each other
///   noise          targets photographed at ISO 400
///   by hand        three targets instead of eight at each of four focus distances from infinity to 0.2 m, tilted by
///   one
///                  degree: twelve photographs
///   matching       the calibration of "targets", on the disparity that the default matcher finds in rendered views of
///                  a textured plane at ISO 100: means over squares of 16 x 16 DP px
/// All but the last judge the traced lens's own disparity. Throws InputError where the camera cannot be calibrated.
std::vector<CalibrationRemainder> measure_remainders(const simulator::Simulation& simulation, double plane_m);

}  // namespace dualpixel::evaluation
