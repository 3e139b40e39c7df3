#include "evaluation/benchmarks/lens_benchmark.h"

#include <tbb/global_control.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "capture/timing.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/lens_candidates.h"
#include "simulator/render/views.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kSensorWidth = 1344, kSensorHeight = 1008, kSamples = 16;

/// RMS over the field and over depths, DP px.
double disparity_error(const simulator::LensSampler& lens, const simulator::LensSampler& reference) {
  double sum = 0;
  int count = 0;
  const simulator::SensorGrid& sensor = lens.sensor();
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 12; ++column) {
      const int x = (2 * column + 1) * sensor.width_px / 24, y = (2 * row + 1) * sensor.height_px / 18;
      const simulator::DisparityCoefficients a = trace_disparity(lens, x, y, 2048);
      const simulator::DisparityCoefficients b = trace_disparity(reference, x, y, 2048);
      for (double diopters : {0.0, 0.5, 1.0, 2.0, 4.0}) {
        const double error = (a.slope_dp_px_m - b.slope_dp_px_m) * diopters + a.intercept_dp_px - b.intercept_dp_px;
        sum += error * error;
        ++count;
      }
    }
  }
  return std::sqrt(sum / count);
}

LensBenchmark measure_lens(const std::string& file, const simulator::Simulation& s, const simulator::RenderScene& world,
                           const glm::mat4& pose) {
  const simulator::Lens lens = simulator::read_lens_file(file, s.lens.thin.focus_distance_m);
  if (simulator::image_radius_mm(lens) == 0) {
    throw InputError(printable(file) + ": /model: has no image circle to fill");
  }
  const double radius_m = 1e-3 * simulator::image_radius_mm(lens);
  const simulator::SensorGrid sensor{kSensorWidth,
                                     kSensorHeight,
                                     radius_m * 2 / std::hypot(kSensorWidth, kSensorHeight),
                                     {kSensorWidth / 2, kSensorHeight / 2}};
  const std::vector<simulator::LensCandidate> models = simulator::lens_candidates(lens);
  std::vector<simulator::CameraView> cameras;
  std::vector<double> ready_s, render_s(models.size(), 1e30);
  for (const simulator::LensCandidate& model : models) {
    ready_s.push_back(seconds([&] { cameras.push_back({pose, {model.lens, sensor}}); }));
  }
  // Models take turns, so that a busy machine slows all of them.
  for (int repeat = 0; repeat < 3; ++repeat) {
    for (std::size_t i = 0; i < models.size(); ++i) {
      render_s[i] = std::min(render_s[i], seconds([&] {
                               simulator::render_views(world, cameras[i], {kSamples, 0, 1});
                             }));
    }
  }
  LensBenchmark result{lens.name, file, {}};
  const double samples = double{kSensorWidth} * double{kSensorHeight} * kSamples;
  for (std::size_t i = 0; i < models.size(); ++i) {
    result.models.push_back({models[i].name, ready_s[i], samples / render_s[i], render_s[i] / render_s[0],
                             disparity_error(cameras[i].lens, cameras.back().lens)});
  }
  return result;
}

}  // namespace

std::vector<LensBenchmark> measure_lenses(const std::vector<std::string>& lens_files, const std::string& scene_file) {
  const simulator::Simulation s = simulator::read_simulation(read_json_file(scene_file), scene_file);
  const simulator::Scene scene = simulator::load_scene(s);
  const simulator::RenderScene world(scene);
  const glm::mat4 pose = simulator::place_camera(s, scene).world_from_camera;
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<LensBenchmark> lenses;
  for (const std::string& file : lens_files) lenses.push_back(measure_lens(file, s, world, pose));
  return lenses;
}

nlohmann::ordered_json to_json(const std::vector<LensBenchmark>& lenses, const std::string& scene_file) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const LensBenchmark& lens : lenses) {
    nlohmann::ordered_json models = nlohmann::ordered_json::array();
    for (const LensModelCost& m : lens.models) {
      models.push_back({{"model", m.model},
                        {"ready_s", m.ready_s},
                        {"samples_per_core_s", m.samples_per_core_s},
                        {"time_over_thin", m.time_over_thin},
                        {"disparity_error_dp_px", m.disparity_error_dp_px}});
    }
    all.push_back({{"lens", lens.lens}, {"file", lens.file}, {"models", models}});
  }
  return {{"scene", scene_file}, {"lenses", all}};
}

}  // namespace dualpixel::evaluation
