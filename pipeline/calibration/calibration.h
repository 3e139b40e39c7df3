#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "pipeline/calibration/flow.h"

/// The same disparity everywhere for the same depth (Wadhwa et al. 2018, section 4.2 "Imaging Model and Calibration").
/// A lens's aberrations leave disparity linear in inverse depth, but the line differs from place to place:
///     d(x, z, D) = S_z(x) / D + I_z(x),       z focus distance, D depth, x place on the sensor.
/// A sweep of a textured, fronto-parallel target over both distances gives S_z and I_z by least squares, and
///     d_corrected = I_z(0) + S_z(0) (d - I_z(x)) / S_z(x)
/// is what the middle of the picture would have seen.
namespace dualpixel::pipeline {

/// Maps over the field are grids of this many nodes, bicubic in between. Node (i, j) lies at
/// (i / (columns - 1) * width, j / (rows - 1) * height) of the picture: the outermost are on its border.
inline constexpr int kCalibrationColumns = 41;
inline constexpr int kCalibrationRows = 31;

/// What one capture of the target says.
struct TargetMeasurement {
  double focus_distance_m = 0;   ///< infinity is allowed
  double target_distance_m = 0;  ///< planar depth on the axis
  Image disparity_dp_px;         ///< at the nodes
  Image usable;                  ///< 1 where the views matched, 0 elsewhere
};

/// `left` and `right` are the linear views. A node is usable where the mismatch of the matched views is below
/// `most_mismatch` (0 equal, 2 unrelated).
TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m, const FlowOptions& options = {}, float most_mismatch = 0.5f);

/// The lines of one focus distance; every image has one pixel a node.
struct FocusCalibration {
  double focus_distance_m = 0;
  Image slope_dp_px_m;    ///< S; 0 where fewer than three targets were usable
  Image intercept_dp_px;  ///< I
  Image residual_dp_px;   ///< root mean square of the measurements about the line
  Image r_squared;        ///< share of their variance that the line explains
  Image count;            ///< usable targets
};

struct Calibration {
  Camera camera;  ///< name and intrinsics that it holds for; focus_distance_m is unused
  double nearest_target_m = 0, farthest_target_m = 0;
  std::vector<FocusCalibration> focuses;  ///< from far to near focus
  std::vector<std::string> warnings;      ///< about the sweep, for people
};

/// Measurements in any order, all of `camera`. Throws InputError where a focus distance has fewer than three different
/// target distances, where they span less than 0.2 / m of inverse depth, or where the middle of the picture has no
/// line. Warns where the target seems to be tilted.
Calibration fit_calibration(const Camera& camera, const std::vector<TargetMeasurement>& measurements);

/// How far the target of a measurement was from fronto-parallel, degrees; x: its right side farther, y: its lower side.
/// A tilted plane's inverse depth is linear in the picture, so a tilt makes the slope's part that is odd about the
/// middle; what is even is the lens's. A lens that is not symmetric itself looks like a tilt.
struct TargetTilt {
  double x_deg = 0, y_deg = 0;
};
TargetTilt estimate_tilt(const Camera& camera, const FocusCalibration& lines, const TargetMeasurement& measurement);

/// S and I of one place, bicubic between nodes. `x` and `y` run from 0 to 1 over the picture.
struct CalibrationLine {
  double slope_dp_px_m = 0, intercept_dp_px = 0;
};
CalibrationLine line_at(const FocusCalibration& focus, double x, double y);

/// S_z and I_z at any focus distance within the calibrated range: linear between its neighbours in 1/z, in which both
/// are nearly linear (the thin lens's intercept is -S/z), and which has room for infinity. Outside the nearest.
FocusCalibration focus_at(const Calibration& calibration, double focus_distance_m);

/// The correction for one capture, ready to be applied to its maps.
struct Correction {
  Image gain, offset_dp_px;  ///< at the nodes: d_corrected = gain d + offset
  Image usable;              ///< 0: no line, or a slope below a fifth of the middle's: what is left there is noise
  float confidence = 1;      ///< exp(-distance / 0.5 per metre) to the calibrated range of 1/z; 1 inside
  std::string warning;       ///< names both where the focus distance lies outside the range; else empty
};

/// Throws InputError where `camera` differs from `own` in name, size, pixel pitch, DP pixel, focal length, f-number or
/// principal point; `what` begins the message.
void require_same_camera(const Camera& own, const Camera& camera, const std::string& what);

/// Throws InputError where `camera` is not the calibration's.
Correction make_correction(const Calibration& calibration, const Camera& camera);

/// In place, at any resolution of the same picture. Confidence is scaled by the correction's, and 0 where that is not
/// usable at one of the four nodes around; disparity is finite everywhere.
void correct_disparity(const Correction& correction, Image& disparity_dp_px, Image& confidence);

/// calibration.json: {"format", "version": 1, "camera": {name and intrinsics}, "nearest_target_m", "farthest_target_m",
/// "warnings", "focuses": [{"focus_distance_m", "slope_dp_px_m": [41 x 31 row by row], ...}]}.
nlohmann::ordered_json to_json(const Calibration& calibration);
/// Every field checked; `file` names it in messages. Throws InputError.
Calibration read_calibration(const nlohmann::json& json, const std::string& file);

/// A measurement as JSON, for resuming a sweep.
nlohmann::ordered_json to_json(const TargetMeasurement& measurement);
TargetMeasurement read_measurement(const nlohmann::json& json, const std::string& file);

}  // namespace dualpixel::pipeline
