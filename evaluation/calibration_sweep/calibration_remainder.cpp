#include "evaluation/calibration_sweep/calibration_remainder.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "capture/image/resample.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/calibration_sweep/plane_disparity.h"
#include "evaluation/calibration_sweep/traced_skew.h"
#include "evaluation/methods/disparity_method.h"
#include "pipeline/calibration/nodes.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::kCalibrationColumns;
using pipeline::kCalibrationRows;

constexpr int kSquare_px = 16;
constexpr double kBaseIso = 100, kHighIso = 400;

/// What a sweep without any error would measure at that focus distance.
pipeline::FocusCalibration traced_lines(const simulator::Simulation& simulation, double focus_distance_m) {
  const simulator::DisparityField field(focused_lens(simulation, focus_distance_m));
  pipeline::FocusCalibration lines;
  lines.focus_distance_m = focus_distance_m;
  lines.r_squared = 1;
  lines.slope_dp_px_m = lines.intercept_dp_px = lines.residual_dp_px = pipeline::node_image();
  for (int j = 0; j < kCalibrationRows; ++j) {
    for (int i = 0; i < kCalibrationColumns; ++i) {
      const simulator::DisparityCoefficients c =
          field.at(1.0 * i / (kCalibrationColumns - 1) * simulation.sensor.width_px,
                   1.0 * j / (kCalibrationRows - 1) * simulation.sensor.height_px);
      lines.slope_dp_px_m.at(i, j) = static_cast<float>(c.slope_dp_px_m);
      lines.intercept_dp_px.at(i, j) = static_cast<float>(c.intercept_dp_px);
    }
  }
  return lines;
}

/// Seen at the resolution of its DP pixels.
TargetViews photograph_plane(const simulator::Simulation& simulation, double plane_m) {
  constexpr int kRaysPerPixel = 128, kFinest_px = 16;
  const Camera camera = describe_camera(simulation);
  const TargetCamera views =
      make_target_camera(focused_lens(simulation, camera.focus_distance_m), camera.dp_width(), camera.dp_height());
  TargetViews plane = render_target(views, {plane_m, 0, 1, kFinest_px}, kRaysPerPixel);
  const pipeline::ViewNoise noise = frame_noise(simulation.sensor, kBaseIso);
  add_noise(plane.left, noise, 1);
  add_noise(plane.right, noise, 2);
  return plane;
}

Image matched_disparity(const simulator::Simulation& simulation, double plane_m, const pipeline::SkewField& skew) {
  const TargetViews plane = photograph_plane(simulation, plane_m);
  pipeline::ViewSensor sensor;
  sensor.noise = frame_noise(simulation.sensor, kBaseIso);
  sensor.skew = skew;
  const DisparityMethod method = method_named(std::string(pipeline::kDefaultMatcher));
  return method.run(plane.left, plane.right, of_camera(sensor, describe_camera(simulation))).found.disparity_dp_px;
}

}  // namespace

std::vector<CalibrationRemainder> measure_remainders(const simulator::Simulation& simulation, double plane_m) {
  const Camera camera = describe_camera(simulation);
  const double focus_m = camera.focus_distance_m;
  const simulator::DisparityField field(focused_lens(simulation, focus_m));
  const Image plane = plane_disparity(field, camera, plane_m);
  std::vector<CalibrationRemainder> remainders;
  const auto add = [&](const std::string& cause, const pipeline::Calibration& calibration, Image disparity) {
    Image confidence(disparity.width, disparity.height, 1, 1.0f);
    correct_disparity(make_correction(calibration, camera), disparity, confidence);
    remainders.push_back({cause, deviation_inside(disparity)});
  };
  const auto traced = [&](std::initializer_list<double> focuses) {
    pipeline::Calibration calibration{camera, 0.1, 10, {}, {}};
    for (const double focus : focuses) calibration.focuses.push_back(traced_lines(simulation, focus));
    return calibration;
  };
  const auto measured = [&](const SweepOptions& options) {
    return fit_calibration(camera, measure_around(simulation, focus_m, options));
  };
  SweepOptions noisy, by_hand;
  noisy.noise = by_hand.noise = frame_noise(simulation.sensor, kHighIso);
  by_hand.focuses = 5, by_hand.targets = 3, by_hand.tilt_x_deg = 1;
  pipeline::Calibration calibration = measured({});
  add("grid", traced({focus_m}), plane);
  const auto [far_m, near_m] = focuses_around(focus_m, {}).focus_distances_m;
  add("focus", traced({far_m, near_m}), plane);
  add("targets", calibration, plane);
  add("noise", measured(noisy), plane);
  add("by hand", measured(by_hand), plane);
  constexpr int kLeastSquares = 10;
  const int columns = camera.dp_width() / kSquare_px, rows = camera.dp_height() / kSquare_px;
  if (std::isfinite(plane_m) && std::min(columns, rows) >= kLeastSquares) {
    add_traced_skew(simulation, calibration);
    const pipeline::SkewField skew = make_correction(calibration, camera).skew;
    add("matching", calibration, resize_area(matched_disparity(simulation, plane_m, skew), columns, rows));
  } else {
    remainders.push_back({"matching", std::numeric_limits<double>::quiet_NaN()});
  }
  return remainders;
}

}  // namespace dualpixel::evaluation
