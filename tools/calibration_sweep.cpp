#include "tools/calibration_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::tools {
namespace {

simulator::Lens focused(const simulator::Simulation& simulation, double focus_distance_m) {
  try {
    return simulator::refocused(simulation.lens, focus_distance_m);
  } catch (const std::invalid_argument& error) {
    throw InputError(
        fmt::format("{}: /lens: focused at {:g} m: {}", printable(simulation.path), focus_distance_m, error.what()));
  }
}

constexpr pipeline::FlowOptions kFlow{};

int blocks(int photosites, int per_block) { return std::max((photosites + per_block / 2) / per_block, 1); }

/// Its pixels are the flow's blocks.
TargetCamera target_camera(const simulator::Simulation& simulation, const simulator::Lens& lens) {
  const simulator::SensorOptions& sensor = simulation.sensor;
  try {
    return make_target_camera(simulator::LensSampler(lens, simulator::sensor_grid(simulation)),
                              blocks(sensor.width_px, sensor.dp_downsample_x * kFlow.block_width_px),
                              blocks(sensor.height_px, sensor.dp_downsample_y * kFlow.block_height_px));
  } catch (const std::invalid_argument& error) {
    throw InputError(printable(simulation.path) + ": /lens: " + error.what());
  }
}

void add_noise(Image& view, const NoiseProfile& noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (float& x : view.data) x += static_cast<float>(std::sqrt(noise.shot_dn * x + noise.read_dn2) * normal(random));
}

}  // namespace

std::vector<double> sweep_focus_distances(const SweepOptions& options) {
  std::vector<double> distances;
  for (int i = 0; i < options.focuses; ++i) {
    const double inverse = i / (options.nearest_focus_m * (options.focuses - 1));
    distances.push_back(i == 0 ? std::numeric_limits<double>::infinity() : 1 / inverse);
  }
  return distances;
}

std::vector<double> sweep_target_distances(const simulator::Lens& lens, double dp_pitch_um,
                                           const SweepOptions& options) {
  const double slope_dp_px_m = std::abs(lens.split.alpha(lens.thin.rim_slope())) * lens.thin.pupil_diameter_m() *
                               lens.thin.image_distance_m() / (1e-6 * dp_pitch_um);
  const double focus = 1 / lens.thin.focus_distance_m, reach = options.reach_dp_px / slope_dp_px_m;
  const double far = std::max(focus - reach, 1 / options.farthest_target_m), near = std::max(focus + reach, far + 1);
  std::vector<double> distances;
  for (int i = 0; i < options.targets; ++i) distances.push_back(1 / (far + (near - far) * i / (options.targets - 1)));
  return distances;
}

FocusSweep::FocusSweep(const simulator::Simulation& simulation, double focus_distance_m, const SweepOptions& options)
    : options_(options),
      targets_(sweep_target_distances(focused(simulation, focus_distance_m),
                                      simulation.sensor.pixel_pitch_um * simulation.sensor.dp_downsample_x, options)),
      camera_(target_camera(simulation, focused(simulation, focus_distance_m))),
      dp_px_per_pixel_(static_cast<float>(simulation.sensor.width_px) /
                       static_cast<float>(simulation.sensor.dp_downsample_x * camera_.width)) {}

pipeline::TargetMeasurement FocusSweep::measure(double distance_m, std::uint64_t seed) const {
  const CalibrationTarget target{distance_m, options_.tilt_x_deg, options_.tilt_y_deg, seed, options_.finest_px};
  TargetViews views = render_target(camera_, target, options_.rays);
  if (options_.noise.shot_dn > 0 || options_.noise.read_dn2 > 0) {
    constexpr int kPixels = kFlow.block_width_px * kFlow.block_height_px;
    const NoiseProfile of_block = {options_.noise.shot_dn / kPixels, options_.noise.read_dn2 / kPixels};
    add_noise(views.left, of_block, simulator::hash(seed, 1));
    add_noise(views.right, of_block, simulator::hash(seed, 2));
  }
  pipeline::FlowOptions flow;
  flow.block_width_px = flow.block_height_px = 1;
  pipeline::TargetMeasurement m =
      pipeline::measure_target(views.left, views.right, camera_.lens.lens().thin.focus_distance_m, distance_m, flow);
  for (float& d : m.disparity_dp_px.data) d *= dp_px_per_pixel_;
  return m;
}

std::vector<pipeline::TargetMeasurement> run_sweep(const simulator::Simulation& simulation, const SweepOptions& options,
                                                   const std::string& folder,
                                                   const std::function<void(double)>& progress) {
  std::vector<pipeline::TargetMeasurement> measurements;
  const std::vector<double> focuses = sweep_focus_distances(options);
  const double all = static_cast<double>(options.focuses) * options.targets;
  for (int i = 0; i < options.focuses; ++i) {
    const auto file = [&](int j) { return fmt::format("{}/focus_{:02}_target_{:02}.json", folder, i, j); };
    std::optional<FocusSweep> sweep;  // made when something is left to measure: a lens takes a second to get ready
    for (int j = 0; j < options.targets; ++j) {
      std::error_code error;
      if (!folder.empty() && std::filesystem::exists(file(j), error)) {
        measurements.push_back(pipeline::read_measurement(read_json_file(file(j)), file(j)));
      } else {
        if (!sweep) sweep.emplace(simulation, focuses[i], options);
        const pipeline::TargetMeasurement measured =
            sweep->measure(sweep->target_distances_m()[j], simulator::hash(options.seed, i * 1000 + j));
        // through JSON, kept or not: a sweep that went on must end as one that was not interrupted
        const nlohmann::json json = to_json(measured);
        if (!folder.empty()) replace_file(file(j), json.dump() + "\n");
        measurements.push_back(pipeline::read_measurement(json, file(j)));
      }
      if (progress) progress((i * options.targets + j + 1) / all);
    }
  }
  return measurements;
}

}  // namespace dualpixel::tools
