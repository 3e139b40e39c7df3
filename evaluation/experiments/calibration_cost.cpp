#include "evaluation/experiments/calibration_cost.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/timing.h"
#include "evaluation/calibration_sweep/plane_disparity.h"

namespace dualpixel::evaluation {
namespace {

std::vector<CalibrationEffort> efforts(const simulator::SensorOptions& sensor) {
  std::vector<CalibrationEffort> all;
  const auto add = [&](const std::string& axis, const std::string& name, const auto& change) {
    CalibrationEffort effort{axis, name, {}, 0, {}, false};
    change(effort.sweep);
    all.push_back(effort);
  };
  for (const int n : {5, 10, 20, 40}) {
    add("focus distances", std::to_string(n), [&](SweepOptions& s) { s.focuses = n; });
  }
  for (const int n : {4, 8, 16}) {
    add("target distances", std::to_string(n), [&](SweepOptions& s) { s.targets = n; });
  }
  // one frame of a phone's sensor
  for (const float gain : {1.0f, 4.0f, 16.0f}) {
    add("noise", fmt::format("ISO {:g}", 100 * gain),
        [&](SweepOptions& s) { s.noise = frame_noise(sensor, 100 * gain); });
  }
  for (const int finest : {16, 32, 64}) {
    add("texture", fmt::format("cells of {} px", finest), [&](SweepOptions& s) { s.finest_px = finest; });
  }
  for (const double tilt : {0.0, 1.0, 2.0, 5.0}) {
    add("tilt", fmt::format("{:g} degrees", tilt), [&](SweepOptions& s) { s.tilt_x_deg = tilt; });
  }
  return all;
}

}  // namespace

double field_deviation_dp_px(const simulator::DisparityField& field, const Camera& camera,
                             const pipeline::Correction* correction) {
  double variance = 0;
  for (const double depth : kCostDepths_m) {
    variance += std::pow(deviation_inside(plane_disparity(field, camera, depth, correction)), 2);
  }
  return std::sqrt(variance / static_cast<double>(std::size(kCostDepths_m)));
}

namespace {

void measure_effort(const simulator::Simulation& simulation, const simulator::DisparityField& field,
                    CalibrationEffort& effort) {
  const std::vector<pipeline::TargetMeasurement> measurements = measure_around(simulation, kCostFocus_m, effort.sweep);
  Camera camera = describe_camera(simulation);
  const pipeline::Calibration calibration = fit_calibration(camera, measurements);
  camera.focus_distance_m = kCostFocus_m;
  const pipeline::Correction correction = make_correction(calibration, camera);
  effort.residual_dp_px = field_deviation_dp_px(field, camera, &correction);
  effort.tilt = estimate_tilt(camera, measurements);
  effort.warned = !calibration.warnings.empty();
}

}  // namespace

CalibrationCost measure_calibration_cost(const simulator::Simulation& simulation,
                                         const std::function<void(double)>& progress) {
  CalibrationCost cost;
  cost.lens = simulation.lens.name;
  cost.efforts = efforts(simulation.sensor);
  const simulator::DisparityField field(FocusSweep(simulation, kCostFocus_m, {}).lens());
  cost.uncorrected_dp_px = field_deviation_dp_px(field, describe_camera(simulation), nullptr);
  for (std::size_t i = 0; i < cost.efforts.size(); ++i) {
    CalibrationEffort& effort = cost.efforts[i];
    effort.memory_mb = peak_mb([&] { measure_effort(simulation, field, effort); });
    progress(static_cast<double>(i + 1) / static_cast<double>(cost.efforts.size()));
  }
  return cost;
}

nlohmann::ordered_json to_json(const CalibrationCost& cost) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const CalibrationEffort& e : cost.efforts) {
    rows.push_back({{"axis", e.axis},
                    {"value", e.value},
                    {"photographs", e.photographs()},
                    {"residual_sigma_dp_px", e.residual_dp_px},
                    {"tilt_found_deg", e.tilt.x_deg},
                    {"tilt_standard_error_deg", e.tilt.x_error_deg},
                    {"tilt_warning", e.warned},
                    {"memory_mb", e.memory_mb}});
  }
  return {{"format", "dualpixel-experiment-calibration"},
          {"version", 2},
          {"lens", cost.lens},
          {"focus_distance_m", kCostFocus_m},
          {"depths_m", kCostDepths_m},
          {"uncorrected_sigma_dp_px", cost.uncorrected_dp_px},
          {"efforts", rows}};
}

}  // namespace dualpixel::evaluation
