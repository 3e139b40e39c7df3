#include "evaluation/calibration_sweep/calibration_remainder.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "capture/image/resample.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/calibration_sweep/plane_disparity.h"
#include "evaluation/methods/disparity_method.h"
#include "pipeline/calibration/nodes.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::kCalibrationColumns;
using pipeline::kCalibrationRows;

constexpr int kSquare_px = 16;
constexpr float kShot = 4e-5f, kRead = 1e-7f;  // of one frame at ISO 100, over white

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

/// The two of a sweep's focus distances around `focus_distance_m`.
std::vector<double> focuses_around(double focus_distance_m, const SweepOptions& options) {
  SweepOptions reaching = options;
  reaching.nearest_focus_m = std::min(options.nearest_focus_m, focus_distance_m);
  const std::vector<double> all = sweep_focus_distances(reaching);  // from far to near
  const auto near = std::find_if(all.begin() + 1, all.end() - 1, [&](double z) { return z <= focus_distance_m; });
  return {*(near - 1), *near};
}

/// Seen at the resolution of its DP pixels.
TargetViews photograph_plane(const simulator::Simulation& simulation, double plane_m) {
  constexpr int kRaysPerPixel = 128, kFinest_px = 16;
  const Camera camera = describe_camera(simulation);
  const TargetCamera views =
      make_target_camera(focused_lens(simulation, camera.focus_distance_m), camera.dp_width(), camera.dp_height());
  TargetViews plane = render_target(views, {plane_m, 0, 1, kFinest_px}, kRaysPerPixel);
  std::mt19937_64 random(1);
  std::normal_distribution<float> normal;
  for (Image* view : {&plane.left, &plane.right}) {
    for (float& value : view->data) value += std::sqrt(kShot * value + kRead) * normal(random);
  }
  return plane;
}

Image matched_disparity(const simulator::Simulation& simulation, double plane_m) {
  const TargetViews plane = photograph_plane(simulation, plane_m);
  pipeline::ViewSensor sensor;
  sensor.noise = {kShot, kRead};
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
  const auto traced = [&](const std::vector<double>& focuses) {
    pipeline::Calibration calibration{camera, 0.1, 10, {}, {}};
    for (const double focus : focuses) calibration.focuses.push_back(traced_lines(simulation, focus));
    return calibration;
  };
  const auto measured = [&](const SweepOptions& options) {
    return fit_calibration(camera, measure_around(simulation, focus_m, options));
  };
  SweepOptions noisy, by_hand;
  noisy.noise = by_hand.noise = {4 * kShot, 4 * kRead};
  by_hand.focuses = 4, by_hand.targets = 3, by_hand.tilt_x_deg = 1;
  const pipeline::Calibration calibration = measured({});
  add("grid", traced({focus_m}), plane);
  add("focus", traced(focuses_around(focus_m, {})), plane);
  add("targets", calibration, plane);
  add("noise", measured(noisy), plane);
  add("by hand", measured(by_hand), plane);
  const Image found = matched_disparity(simulation, plane_m);
  add("matching", calibration, resize_area(found, found.width / kSquare_px, found.height / kSquare_px));
  return remainders;
}

}  // namespace dualpixel::evaluation
