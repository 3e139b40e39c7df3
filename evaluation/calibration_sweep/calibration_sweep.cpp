#include "evaluation/calibration_sweep/calibration_sweep.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <random>
#include <stdexcept>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "pipeline/calibration/flow.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kReach_dp_px = 1;
constexpr double kFarthestTarget_m = 3;
constexpr double kLeastSpan_per_m = 1;
constexpr int kRays = 128;  ///< a block of DP pixels, as FlowOptions averages them

simulator::Lens refocused(const simulator::Simulation& simulation, double focus_distance_m) {
  try {
    return simulator::refocused(simulation.lens, focus_distance_m);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: /lens: {}", printable(simulation.path), error.what()));
  }
}

constexpr pipeline::FlowOptions kFlow{};

int blocks(int photosites, int per_block) { return std::max((photosites + per_block / 2) / per_block, 1); }

/// Its pixels are the flow's blocks.
TargetCamera target_camera(const simulator::Simulation& simulation, double focus_distance_m) {
  const simulator::SensorOptions& sensor = simulation.sensor;
  return make_target_camera(focused_lens(simulation, focus_distance_m),
                            blocks(sensor.width_px, sensor.dp_downsample_x * kFlow.block_width_px),
                            blocks(sensor.height_px, sensor.dp_downsample_y * kFlow.block_height_px));
}

}  // namespace

pipeline::ViewNoise frame_noise(const simulator::SensorOptions& sensor, double iso) {
  simulator::ExposureOptions exposure;
  exposure.iso = iso;
  return pipeline::view_noise(simulator::describe_exposure(sensor, exposure));
}

void add_noise(Image& view, const pipeline::ViewNoise& noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  for (float& x : view.data) x += std::sqrt(noise.shot * x + noise.read) * normal(random);
}

simulator::LensSampler focused_lens(const simulator::Simulation& simulation, double focus_distance_m) {
  const simulator::Lens lens = refocused(simulation, focus_distance_m);
  try {
    return simulator::LensSampler(lens, simulator::sensor_grid(simulation.sensor));
  } catch (const InputError& error) {
    throw InputError(printable(simulation.path) + ": /lens/" + error.what());
  }
}

void require_focuses(const simulator::Simulation& simulation, const SweepOptions& options) {
  for (const double focus_distance_m : sweep_focus_distances(options)) refocused(simulation, focus_distance_m);
}

std::vector<double> sweep_focus_distances(const SweepOptions& options) {
  std::vector<double> distances;
  for (int i = 0; i < options.focuses; ++i) {
    const double inverse = i / (options.nearest_focus_m * (options.focuses - 1));
    distances.push_back(i == 0 ? std::numeric_limits<double>::infinity() : 1 / inverse);
  }
  return distances;
}

std::vector<double> sweep_target_distances(const simulator::Lens& lens, double dp_pitch_um, int targets) {
  const double slope_dp_px_m = std::abs(lens.split.alpha(lens.thin.rim_slope())) * lens.thin.pupil_diameter_m() *
                               lens.thin.image_distance_m() / (1e-6 * dp_pitch_um);
  const double focus = 1 / lens.thin.focus_distance_m, reach = kReach_dp_px / slope_dp_px_m;
  const double far = std::max(focus - reach, 1 / kFarthestTarget_m);
  const double near = std::max(focus + reach, far + kLeastSpan_per_m);
  std::vector<double> distances;
  for (int i = 0; i < targets; ++i) distances.push_back(1 / (far + (near - far) * i / (targets - 1)));
  return distances;
}

FocusSweep::FocusSweep(const simulator::Simulation& simulation, double focus_distance_m, const SweepOptions& options)
    : options_(options),
      camera_(target_camera(simulation, focus_distance_m)),
      targets_(sweep_target_distances(
          lens().lens(), simulation.sensor.pixel_pitch_um * simulation.sensor.dp_downsample_x, options.targets)),
      dp_px_per_pixel_(static_cast<float>(simulation.sensor.width_px) /
                       static_cast<float>(simulation.sensor.dp_downsample_x * camera_.width)) {}

pipeline::TargetMeasurement FocusSweep::measure(double distance_m, std::uint64_t seed) const {
  const CalibrationTarget target{distance_m, options_.tilt_x_deg, seed, options_.finest_px};
  TargetViews views = render_target(camera_, target, kRays);
  if (options_.noise.shot > 0 || options_.noise.read > 0) {
    constexpr float kPixels = kFlow.block_width_px * kFlow.block_height_px;
    const pipeline::ViewNoise of_block = {options_.noise.shot / kPixels, options_.noise.read / kPixels};
    add_noise(views.left, of_block, simulator::hash(seed, 1));
    add_noise(views.right, of_block, simulator::hash(seed, 2));
  }
  pipeline::FlowOptions flow;
  flow.block_width_px = flow.block_height_px = 1;
  pipeline::TargetMeasurement m =
      pipeline::measure_target(views.left, views.right, lens().lens().thin.focus_distance_m, distance_m, flow);
  for (float& d : m.disparity_dp_px.data) d *= dp_px_per_pixel_;
  return m;
}

FocusesAround focuses_around(double focus_distance_m, const SweepOptions& options) {
  SweepOptions reaching = options;
  reaching.nearest_focus_m = std::min(options.nearest_focus_m, focus_distance_m);
  const std::vector<double> focuses = sweep_focus_distances(reaching);
  const double steps = (options.focuses - 1) * reaching.nearest_focus_m / focus_distance_m;  // from infinity
  const int farther = std::clamp(static_cast<int>(steps), 0, options.focuses - 2);
  return {{focuses[farther], focuses[farther + 1]}, farther};
}

std::vector<pipeline::TargetMeasurement> measure_around(const simulator::Simulation& simulation,
                                                        double focus_distance_m, const SweepOptions& options) {
  const FocusesAround around = focuses_around(focus_distance_m, options);
  std::vector<pipeline::TargetMeasurement> measurements;
  for (const int i : {0, 1}) {
    const FocusSweep sweep(simulation, around.focus_distances_m[i], options);
    for (std::size_t j = 0; j < sweep.target_distances_m().size(); ++j) {
      measurements.push_back(
          sweep.measure(sweep.target_distances_m()[j], simulator::hash(options.seed, around.farther + i, j)));
    }
  }
  return measurements;
}

std::vector<pipeline::TargetMeasurement> run_sweep(const simulator::Simulation& simulation, const SweepOptions& options,
                                                   const std::string& folder,
                                                   const std::function<void(double)>& progress) {
  const std::vector<double> focuses = sweep_focus_distances(options);
  std::vector<pipeline::TargetMeasurement> measurements(static_cast<std::size_t>(options.focuses) * options.targets);
  std::mutex counting;
  std::size_t done = 0;
  for (int i = 0; i < options.focuses; ++i) {
    const auto file = [&](int j) { return fmt::format("{}/focus_{:02}_target_{:02}.json", folder, i, j); };
    const auto kept = [&](int j) {
      std::error_code error;
      return !folder.empty() && std::filesystem::exists(file(j), error);
    };
    std::optional<FocusSweep> sweep;  // made when something is left to measure: a lens takes a second to get ready
    for (int j = 0; j < options.targets && !sweep; ++j) {
      if (!kept(j)) sweep.emplace(simulation, focuses[i], options);
    }
    tbb::parallel_for(0, options.targets, [&](int j) {
      pipeline::TargetMeasurement& measurement = measurements[static_cast<std::size_t>(i) * options.targets + j];
      if (kept(j)) {
        measurement = pipeline::read_measurement(read_json_file(file(j)), file(j));
      } else {
        // through JSON, kept or not: a resumed sweep must give the result of an uninterrupted one
        const nlohmann::json json =
            to_json(sweep->measure(sweep->target_distances_m()[j], simulator::hash(options.seed, i * 1000 + j)));
        if (!folder.empty()) replace_file(file(j), json.dump() + "\n");
        measurement = pipeline::read_measurement(json, file(j));
      }
      const std::lock_guard lock(counting);
      ++done;
      if (progress) progress(static_cast<double>(done) / static_cast<double>(measurements.size()));
    });
  }
  return measurements;
}

}  // namespace dualpixel::evaluation
