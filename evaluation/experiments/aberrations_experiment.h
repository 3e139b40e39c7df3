#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "evaluation/calibration_sweep/calibration_remainder.h"
#include "simulator/scene_file.h"

/// What a lens's aberrations do to the disparity of a plane over the field, and what a calibration leaves of it (Wadhwa
/// et al. 2018, section 4.2 and its figures of aberrations, calibration and corrected pictures).
namespace dualpixel::evaluation {

/// Of one camera. All maps have the same size and cover the picture.
struct AberratedField {
  std::string lens;
  double focus_distance_m = 0, plane_m = 0;
  Image before_dp_px, after_dp_px;  ///< disparity of the plane, as the lens has it and corrected
  Image focus_m;     ///< depth that has no disparity: the surface of sharp focus; beyond infinity: infinity
  Image light;       ///< of both views, over the brightest
  Image left_share;  ///< of the light
  /// Standard deviation of the disparity over the inner 90 % of the field.
  double before_sigma_dp_px = 0, after_sigma_dp_px = 0;
  std::vector<CalibrationRemainder> remainders;  ///< of the same plane; measure_aberrated_field() leaves them out
};

/// The plane is at three times the scene's focus distance. The calibration is a simulated sweep's (8 targets at each of
/// the two focus distances around the scene's); the disparity is the lens's own, by tracing. Throws InputError where
/// the camera cannot be calibrated.
AberratedField measure_aberrated_field(const simulator::Simulation& simulation);

nlohmann::ordered_json to_json(const std::vector<AberratedField>& fields);
std::string to_page(const std::vector<AberratedField>& fields);

}  // namespace dualpixel::evaluation
