#include "evaluation/chart/stages.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/json_fields.h"
#include "evaluation/benchmarks/disparity_benchmark.h"
#include "evaluation/benchmarks/lens_benchmark.h"
#include "evaluation/benchmarks/render_benchmark.h"
#include "evaluation/benchmarks/smoothing_benchmark.h"
#include "evaluation/chart/auto_stage.h"
#include "evaluation/chart/cycles_stage.h"
#include "evaluation/chart/pipeline_stage.h"
#include "evaluation/chart/trials.h"
#include "evaluation/experiments/burst_experiment.h"
#include "evaluation/experiments/calibration_cost.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/edge_aware/smooth_disparity.h"
#include "pipeline/segmentation/network.h"
#include "simulator/render/render_options.h"
#include "simulator/scene_file.h"

namespace dualpixel::evaluation {
namespace {

/// Of the repetitions of what draws numbers. In short there is one, and no standard error.
std::vector<int> seeds_from(int first, const ChartInput& input) {
  return input.quick ? std::vector{first} : std::vector{first, first + 1, first + 2};
}

/// Of adaptive sampling not its own samples, which are another number with each seed.
std::string name_of(const RenderCurve& curve, const RenderRun& run) {
  if (!run.target) return fmt::format("{}, {:.3g} spp", curve.name, run.samples);
  return fmt::format("{}, error of {:.3g} spp", curve.name, run.target->samples);
}

std::vector<Trial> trials_of(const SceneRenderBenchmark& benchmark) {
  std::vector<Trial> trials;
  for (const RenderCurve& curve : benchmark.curves) {
    for (const RenderRun& run : curve.runs) {
      Trial& trial = trials.emplace_back(Trial{name_of(curve, run), run.error, run.time_s});
      trial.is_default = curve.name == "light cache" && run.samples == simulator::RenderOptions().samples_per_pixel;
      trial.is_bound = curve.name == "Embree alone";
    }
  }
  return trials;
}

ChartPart measure_renderer(const ChartInput& input) {
  RenderBenchmarkOptions options;
  if (input.quick) options = {.reference_samples = 256, .most_samples = 32};
  const std::vector<int> seeds = seeds_from(0, input);
  std::vector<std::vector<Trial>> by_seed;
  for (const int seed : seeds) {
    options.seed = static_cast<std::uint64_t>(seed);
    by_seed.push_back(
        trials_of(measure_rendering(input.scenes_folder + "/slanted_planes.json", options, [](double) {})));
  }
  ChartSection section{"Renderer",
                       "24 patches of slanted_planes.json, each way of sampling at growing counts, against a reference "
                       "of many more, whose own error is subtracted; means over three seeds of all camera samples (in "
                       "short, one). Points of light are the scene's own, and the same with each.",
                       "of the sensor's noise",
                       "CPU s",
                       points_of(by_seed),
                       {},
                       {},
                       seeds};
  section.default_reason =
      "mirrored pairs and light at points of surfaces, which take the least time for an error on scenes that are lit "
      "(docs/rendering.md); render.error asks for an error instead of a count. Bound: mirrored pairs' rays in Embree "
      "alone.";
  return {{section}};
}

std::vector<Trial> trials_of(const std::vector<RenderCurve>& light_points) {
  std::vector<Trial> trials;
  for (const RenderCurve& curve : light_points) {
    for (const RenderRun& run : curve.runs) {
      const bool is_default = &curve == &light_points.back() && run.samples == 16;  // as portrait.json has it
      trials.push_back({name_of(curve, run), run.error, run.time_s, curve.memory_mb, is_default});
    }
  }
  return trials;
}

ChartPart measure_light(const ChartInput& input) {
  RenderBenchmarkOptions options{.reference_samples = 1024, .most_samples = 128};
  if (input.quick) options = {.reference_samples = 128, .most_samples = 32};
  const std::vector<int> seeds = seeds_from(0, input);
  std::vector<std::vector<Trial>> by_seed;
  for (const int seed : seeds) {
    options.seed = static_cast<std::uint64_t>(seed);
    by_seed.push_back(
        trials_of(measure_light_points(input.scenes_folder + "/portrait.json", options, {0, 16, 8, 4, 2})));
  }
  ChartSection section{"Light",
                       "24 patches of portrait.json: where the light of a surface is known, at points so many "
                       "photosites apart or by every sample; making the points is in the time. Against a reference of "
                       "many more samples, whose own error is subtracted; means over three seeds of all camera samples "
                       "(in short, one), the points being the same with each. Memory excludes the scene's own.",
                       "of the sensor's noise",
                       "CPU s",
                       points_of(by_seed),
                       {},
                       {},
                       seeds};
  section.default_reason =
      "points so near that interpolating between them adds at most a tenth of the sensor's noise (docs/rendering.md).";
  return {{section}};
}

ChartPart measure_lens_models(const ChartInput& input) {
  std::vector<std::string> files = {input.lenses_folder + "/phone_6p_4.2mm_f1.8.json"};
  if (!input.quick) {
    files.push_back(input.lenses_folder + "/phone_7p_4.9mm_f1.85.json");
    files.push_back(input.lenses_folder + "/full_frame_50mm_f1.8.json");
  }
  std::vector<ChartSection> sections;
  for (const LensBenchmark& lens : measure_lenses(files, input.scenes_folder + "/slanted_planes.json")) {
    ChartSection& section = sections.emplace_back(
        ChartSection{"Lens models: " + lens.lens,
                     "Disparity over the field and over depths against the exact trace, whose own error is none and "
                     "is left out; no samples, so no standard error. Time of a sample of slanted_planes.json on one "
                     "core, the best of three.",
                     "DP px",
                     "ns a sample",
                     {}});
    for (const LensModelCost& model : lens.models) {
      if (model.disparity_error_dp_px == 0) continue;
      section.points.push_back({model.model, {model.disparity_error_dp_px}, {1e9 / model.samples_per_core_s}});
    }
    section.default_reason =
        "none: a scene names its lens, and `dualpixel plan` the cheapest model that it can do with.";
  }
  return {sections};
}

ChartPart measure_merges(const ChartInput& input) {
  constexpr double kLux = 5;
  const std::vector<int> draws = seeds_from(0, input);
  std::vector<std::vector<Trial>> by_draw;
  for (const int draw : draws) {
    std::vector<Trial>& trials = by_draw.emplace_back();
    const Capture burst = take_shaken_burst(kLux, static_cast<unsigned>(draw));
    if (draw == draws.front()) measure_merge(burst, {9});  // what is made once is made before the clock runs
    for (const BurstPoint& point : measure_merge(burst, {1, 2, 4, 9, 15})) {
      const std::string name = fmt::format("{} frame{}", point.frames, point.frames == 1 ? "" : "s");
      trials.push_back({name, 100 * point.merge.views_kept, 1e3 * point.merge.cpu_s});
      trials.push_back({name + ", six channels", 100 * point.six_channels.views_kept, 1e3 * point.six_channels.cpu_s});
    }
  }
  ChartSection section{
      "Merged views: noise left",
      fmt::format("A card before a wall at {} lux, in a shaking hand, on the atlas's small sensor: the "
                  "merged views' RMS error against views without noise, over that of one frame. Frames "
                  "at rest, simply averaged, would leave 100 / √N. Six channels: mosaic and views by one "
                  "weight, as the paper describes it, without our test of whole tiles and written plainly, "
                  "one sample at a time. Means over three draws of textures and noise (in short, one).",
                  kLux),
      "% of one frame's error",
      "CPU ms",
      points_of(by_draw),
      {},
      {},
      draws};
  section.default_reason = "none: all frames that were shot are merged.";
  return {{section}};
}

ChartPart measure_matchers(const ChartInput& input) {
  std::vector<std::string> scenes = {input.scenes_folder + "/slanted_planes.json",
                                     input.scenes_folder + "/occlusion_edges.json"};
  if (!input.quick) scenes.push_back(input.scenes_folder + "/portrait.json");
  const DisparityBenchmark benchmark = measure_disparity(scenes);
  ChartSection section{"Matchers",
                       fmt::format("RMSE of what was answered, and wall time with all threads at 1344 x 1008; standard "
                                   "errors over {} scenes. OpenCV's matchers where the build has them.",
                                   scenes.size()),
                       "DP px",
                       "ms",
                       {}};
  for (std::size_t i = 0; i < benchmark.scenes.front().methods.size(); ++i) {
    std::vector<double> errors, ms;
    for (const DisparityBenchmark::Scene& scene : benchmark.scenes) {
      errors.push_back(scene.methods[i].rmse_dp_px);
      ms.push_back(scene.methods[i].ms);
    }
    const MatcherBenchmark& first = benchmark.scenes.front().methods[i];
    section.points.push_back(
        {first.method, mean_of(errors), mean_of(ms), first.method == pipeline::kDefaultMatcher, first.memory_mb});
  }
  section.default_reason =
      "split: on pairs of a real phone it errs by less than half of the next best, and on scenes near the focus as "
      "little as the likelihood matcher, whose answers it takes there (docs/disparity.md).";
  return {{section}};
}

ChartPart measure_solver(const ChartInput& input) {
  const std::string default_name = fmt::format("resolution: 1/{}", pipeline::SmoothOptions().divisor);
  const std::vector<int> seeds = seeds_from(1, input);
  std::vector<std::vector<Trial>> by_seed;
  for (const int seed : seeds) {
    std::vector<Trial>& trials = by_seed.emplace_back();
    for (const SmoothingComparison& method : measure_smoothing(chart_capture(input, seed)).methods) {
      const std::string name = method.family + ": " + method.name;
      const SmoothingRun& run = method.matched;
      trials.push_back({name, run.errors.rmse_dp_px, run.cpu_ms, run.memory_mb, name == default_name});
    }
  }
  ChartSection section{"Solver and upsampling",
                       "Smoothing of the paper matcher's disparity of bursts of portrait.json, fitted to the truth; "
                       "means over three seeds of all noise (in short, one), memory of the first.",
                       "DP px",
                       "CPU ms",
                       points_of(by_seed),
                       {},
                       {},
                       seeds};
  section.default_reason =
      "of the paper's matcher: its quarter of the size and its other constants; no other filter has less error near "
      "edges on matches (docs/edges.md). The robust solver of matcher split (docs/disparity.md) is not charted.";
  return {{section}};
}

/// How the renderer's cost grows.
ChartPart measure_growth(const ChartInput&) {
  constexpr double kMostTriangles = 1e6;
  const RenderScaling scaling = measure_scaling(kMostTriangles, [](double) {});
  ChartPart part;
  ChartGrowth& triangles =
      part.growths.emplace_back(ChartGrowth{"Renderer: growth with triangles",
                                            "A wall of waves under a sky, one core, points of light known.",
                                            "triangles",
                                            "ns a sample or a ray",
                                            {{"camera sample", {}}, {"ray in Embree alone", {}}}});
  for (const SceneCost& cost : scaling.triangles) {
    triangles.lines[0].second.emplace_back(cost.triangles, cost.cpu_ns);
    triangles.lines[1].second.emplace_back(cost.triangles, cost.ray_ns);
  }
  ChartGrowth& counts = part.growths.emplace_back(
      ChartGrowth{"Renderer: growth with photosites and samples",
                  "Such a wall of 10^5 triangles: CPU time of one sample, which does not grow where cost is in "
                  "proportion to the count.",
                  "photosites of the picture, or samples a photosite",
                  "ns a sample",
                  {{"photosites", {}}, {"samples a photosite", {}}}});
  for (const SampleCost& cost : scaling.photosites) counts.lines[0].second.emplace_back(cost.count, cost.cpu_ns);
  for (const SampleCost& cost : scaling.samples) counts.lines[1].second.emplace_back(cost.count, cost.cpu_ns);
  return part;
}

ChartPart measure_calibration(const ChartInput& input) {
  const std::string file = input.scenes_folder + "/portrait.json";
  nlohmann::json json = read_json_file(file);
  const CalibrationCost cost = measure_calibration_cost(simulator::read_simulation(json, file), [](double) {});
  ChartSection section{"Calibration",
                       "Deviation of a plane's disparity over the field that is left after correction, over the "
                       "photographs that were taken. Memory is that of two focus distances' targets, drawn and "
                       "measured one after another, so that it does not grow with their number.",
                       "DP px",
                       "photographs",
                       {}};
  for (const CalibrationEffort& effort : cost.efforts) {
    const bool is_default = effort.axis == "focus distances" && effort.sweep.focuses == SweepOptions().focuses;
    section.points.push_back({effort.axis + " " + effort.value,
                              {effort.residual_dp_px},
                              {static_cast<double>(effort.photographs())},
                              is_default,
                              effort.memory_mb});
  }
  section.default_reason = "the paper's twenty focus distances (section 4.2), with eight targets at each.";
  return {{section}};
}

}  // namespace

const std::vector<ChartStage>& chart_stages() {
  static const std::vector<ChartStage> stages = {{"pipeline", true, measure_pipeline},
                                                 {"renderer", true, measure_renderer},
                                                 {"light", true, measure_light},
                                                 {"lens models", true, measure_lens_models},
                                                 {"merge", true, measure_merges},
                                                 {"matchers", true, measure_matchers},
                                                 {"solver", true, measure_solver},
                                                 {"disparity by --auto", false, measure_auto},
                                                 {"calibration", false, measure_calibration},
                                                 {"growth", false, measure_growth},
                                                 {"pipeline growth", false, measure_pipeline_growth},
                                                 {"Cycles", false, measure_cycles}};
  return stages;
}

std::vector<std::string> chart_left_out(bool quick) {
  std::vector<std::string> lines;
  if (quick)
    lines.emplace_back(
        "Disparity by --auto, calibration, growth and Cycles: take minutes; without --quick they are here.");
  lines.emplace_back(
      "Networks of other sizes: one is built in; `dualpixel experiment segmentation --weights` judges others.");
  if (!pipeline::has_person_network()) lines.emplace_back("Person masks: this build has no oneDNN.");
  return lines;
}

}  // namespace dualpixel::evaluation
