#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "pipeline/calibration/target_measurement.h"
#include "pipeline/disparity/kernel_skew.h"

/// Calibration of disparity over the field, so that equal depth gives equal disparity (Wadhwa et al. 2018, section 4.2
/// "Imaging Model and Calibration").
/// A lens's aberrations leave disparity linear in inverse depth, but the line varies over the field:
///     d(x, z, D) = S_z(x) / D + I_z(x),       z focus distance, D depth, x position on the sensor.
/// A sweep of a textured, fronto-parallel target over both distances gives S_z and I_z by least squares; correction.h
/// uses them.
namespace dualpixel::pipeline {

/// The lines of one focus distance; every image has one pixel a node.
struct FocusCalibration {
  double focus_distance_m = 0;
  double r_squared = 0;  ///< at the principal point: share of the measurements' variance that its own line explains
  Image slope_dp_px_m;   ///< S, smoothed over nodes nearer than three; 0 where fewer than three targets were usable, or
                         ///< they lie too close together
  Image intercept_dp_px;  ///< I, by that slope
  Image residual_dp_px;   ///< root mean square of the measurements about the node's own line, its slope not smoothed
  SkewField skew;         ///< of the views' kernels, where the lens is known: not from targets; may have no nodes
};

struct Calibration {
  Camera camera;  ///< name and intrinsics that it holds for; focus_distance_m is unused
  double nearest_target_m = 0, farthest_target_m = 0;
  std::vector<FocusCalibration> focuses;  ///< from far to near focus
  std::vector<std::string> warnings;      ///< about the sweep, for people
};

/// Measurements in any order, all of `camera`. Throws InputError where a focus distance has fewer than three different
/// target distances, where they span less than 0.2 / m of inverse depth, or where the node nearest to the principal
/// point has no line. Warns where the target seems to be tilted: by more than 0.7 degrees and 3 standard errors.
Calibration fit_calibration(const Camera& camera, const std::vector<TargetMeasurement>& measurements);

/// Index of the node nearest to the principal point, to which all others are corrected: it must have a line.
std::size_t principal_node(const Camera& camera);

/// calibration.json: {"format", "version": 2, "camera": {name and intrinsics}, "nearest_target_m", "farthest_target_m",
/// "warnings", "focuses": [{"focus_distance_m", "r_squared", "slope_dp_px_m": [21 x 15 row by row], ...,
/// "kernel_skew": {"columns", "rows", "farthest_dp_px", "xxx": [6 coefficients a node], "xyy": [...]}}]}. All focus
/// distances have a kernel_skew of as many nodes, or none has.
nlohmann::ordered_json to_json(const Calibration& calibration);
/// Every field checked; `file` names it in messages. Throws InputError.
Calibration read_calibration(const nlohmann::json& json, const std::string& file);

/// A measurement as JSON, for resuming a sweep.
nlohmann::ordered_json to_json(const TargetMeasurement& measurement);
TargetMeasurement read_measurement(const nlohmann::json& json, const std::string& file);

}  // namespace dualpixel::pipeline
