#include "evaluation/chart/auto_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include "capture/timing.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "evaluation/simulated_scene.h"
#include "pipeline/portrait/run_portrait.h"
#include "scenes/kinds/kinds.h"

namespace dualpixel::evaluation {
namespace {

struct AutoScene {
  const char* kind;  ///< of scenes/kinds/
  std::uint64_t seed;
  int width_px;                          ///< of the whole picture
  std::vector<std::string> assignments;  ///< as SceneOrder has them
};

const std::vector<AutoScene>& auto_scenes() {
  static const std::vector<AutoScene> scenes = {
      {"still_life", 304, 1344, {"light=window", "distance_m=0.25"}},
      {"portrait", 201, 1344, {"people=1", "place=garden", "light=sun", "distance_m=0.8"}},
      {"still_life", 309, 1344, {"light=sun", "distance_m=0.18"}},
      {"portrait", 202, 1344, {"people=3", "place=street", "light=overcast", "distance_m=1.2"}},
      {"still_life", 301, 1344, {"light=window", "distance_m=0.35"}},
      {"portrait", 208, 1344, {"people=1", "place=garden", "light=overcast", "distance_m=0.5"}},
      {"still_life", 301, 2688, {"light=window", "distance_m=0.35", "camera.focus_distance_m=0.15"}},
      {"still_life", 304, 2688, {"light=window", "distance_m=0.25", "camera.focus_distance_m=2"}}};
  return scenes;
}

Capture simulate(const AutoScene& scene, const std::vector<std::string>& fields, const std::string& scratch) {
  scenes::SceneOrder order{scene.kind, scene.seed, scene.assignments};
  order.assignments.insert(order.assignments.end(),
                           {fmt::format("width_px={}", scene.width_px), "lens=phone_thin", "burst.hand_shake=0",
                            "burst.frames=3", "sensor.full_well_e=6000", "sensor.electrons_per_lux_s=[3600,4000,3200]",
                            "render.photograph_samples_per_pixel=1", "render.all_in_focus_samples_per_pixel=1"});
  draw_scene(scenes::scene_kind(scene.kind), order, scratch);
  return simulate_scene(scratch + "/scene.json", fields);
}

pipeline::PortraitOptions disparity_alone(const pipeline::DisparitySetting& setting) {
  pipeline::PortraitOptions options;
  options.mode = pipeline::Mode::dp;
  return with_setting(options, setting);
}

/// Root mean square, and its standard error from the squares' own.
Measured over_scenes(const std::vector<double>& errors) {
  std::vector<double> squares;
  for (const double error : errors) squares.push_back(error * error);
  const Measured mean = mean_of(squares);
  Measured root{std::sqrt(mean.value)};
  if (mean.standard_error) root.standard_error = *mean.standard_error / (2 * root.value);
  return root;
}

}  // namespace

int auto_scene_count() { return static_cast<int>(auto_scenes().size()); }

Capture simulate_auto_scene(int index, const std::string& scratch) {
  return simulate(
      auto_scenes().at(index),
      {"sensor.width_px=672", "sensor.height_px=504", "render.samples_per_pixel=24", "render.light_samples=16"},
      scratch);
}

double disparity_error(const Capture& capture, const pipeline::DisparitySetting& setting) {
  const Image found = pipeline::run_portrait(capture, disparity_alone(setting)).disparity_dp_px;
  const Image& truth = capture.truth->disparity_dp_px;
  std::vector<float> estimates, truths;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (!std::isfinite(truth.data[i])) continue;
    estimates.push_back(found.data[i]);
    truths.push_back(truth.data[i]);
  }
  return rmse(estimates, truths);
}

double disparity_cpu_ms(const Capture& capture, const pipeline::DisparitySetting& setting) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 3; ++run) {
    double ms = 0, start = 0;
    std::string running;
    pipeline::run_portrait(capture, disparity_alone(setting), {}, [&](const std::string& stage, double) {
      const double now = 1e3 * cpu_clock_s();
      const bool counts = stage == "disparity" || stage == "smooth" || stage == "upsample";
      if (counts && running == stage) ms += now - start;  // called before a stage and after it
      running = running == stage ? "" : stage;
      start = now;
    });
    least = std::min(least, ms);
  }
  return least;
}

ChartPart measure_auto(const ChartInput& input) {
  ChartSection section{
      "Disparity by --auto",
      fmt::format("The settings that `portrait --auto` chooses from: matching, smoothing and upsampling "
                  "together. Error: root mean square over {} drawn scenes, two of them far out of "
                  "focus; standard errors over the scenes. Time: of one picture of 2688 x 2016.",
                  auto_scene_count()),
      "DP px",
      "CPU ms",
      {}};
  const std::string folder = input.scratch + "/auto";
  std::filesystem::create_directories(folder);
  std::vector<std::vector<double>> errors(pipeline::disparity_settings().size());
  for (int i = 0; i < auto_scene_count(); ++i) {
    const Capture capture = simulate_auto_scene(i, folder);
    for (std::size_t k = 0; k < errors.size(); ++k) {
      errors[k].push_back(disparity_error(capture, pipeline::disparity_settings()[k]));
    }
  }
  const Capture large = simulate(auto_scenes().back(), {"render.samples_per_pixel=4"}, folder);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const pipeline::DisparitySetting& setting = pipeline::disparity_settings()[k];
    const bool is_default = setting.matcher == pipeline::kDefaultMatcher && setting.assignments.empty();
    section.points.push_back(
        {std::string(setting.name), over_scenes(errors[k]), {disparity_cpu_ms(large, setting)}, is_default});
  }
  section.default_reason =
      "it errs least on a real phone's pairs, and no more than the others here (docs/disparity.md).";
  return {{section}};
}

}  // namespace dualpixel::evaluation
