#include "evaluation/chart/pipeline_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "capture/capture.h"
#include "capture/timing.h"
#include "evaluation/chart/bf16_masks.h"
#include "evaluation/chart/trials.h"
#include "evaluation/experiments/defocus_experiment.h"
#include "evaluation/metrics/scoring.h"
#include "evaluation/simulated_scene.h"
#include "pipeline/portrait/result_io.h"
#include "pipeline/portrait/run_portrait.h"

namespace dualpixel::evaluation {
namespace {

/// portrait.json's whole view on so many photosites.
std::vector<std::string> of_width(int width) {
  constexpr int kFullWidth = 2688;
  constexpr double kFullPitch_um = 1.4;
  return {fmt::format("sensor.width_px={}", width), fmt::format("sensor.height_px={}", width * 3 / 4),
          fmt::format("sensor.pixel_pitch_um={}", kFullPitch_um * kFullWidth / width)};
}

/// One burst of portrait.json, of its whole view with fewer and larger photosites. Seeds differ in all noise, the
/// rendering's included. In short: a hand at rest, so that one render serves all frames, and fewer samples.
Capture simulate_burst(const ChartInput& input, int seed) {
  std::vector<std::string> fields = of_width(input.quick ? 448 : 1344);
  fields.push_back(fmt::format("render.seed={}", seed));
  if (input.quick) {
    fields.insert(fields.end(),
                  {"burst.hand_shake=0", "render.samples_per_pixel=32", "render.photograph_samples_per_pixel=48"});
  }
  return simulate_scene(input.scenes_folder + "/portrait.json", fields);
}

/// A way to run the pipeline, and its figures on each capture.
struct Setting {
  std::string name;
  pipeline::PortraitOptions options;
  std::string mode;
  std::size_t frames = 0;  ///< 0: all
  bool is_default = false;
  std::vector<double> cpu_ms, disparity_dp_px, portrait_percent;
  std::optional<double> memory_mb = {};
  std::vector<pipeline::StageTime> stages = {};  ///< on the first capture
};

std::vector<Setting> mode_settings() {
  std::vector<Setting> settings;
  for (const auto& mode : pipeline::kModes) {
    if (mode.value == pipeline::Mode::automatic) continue;  // dp+seg here, where a person is seen
    for (const pipeline::Matcher& matcher : pipeline::matchers()) {
      const bool by_default = matcher.name == pipeline::kDefaultMatcher;
      if (mode.value == pipeline::Mode::seg && !by_default) continue;  // matches nothing
      Setting& setting = settings.emplace_back();
      setting.mode = mode.name;
      setting.name = setting.mode;
      if (mode.value != pipeline::Mode::seg) setting.name += fmt::format(", {}", matcher.name);
      setting.options = pipeline::default_options(matcher.name);
      setting.options.mode = mode.value;
      setting.is_default = by_default && mode.value == pipeline::Mode::dp_seg;  // what mode auto chooses here
    }
  }
  return settings;
}

std::vector<Setting> frame_settings() {
  std::vector<Setting> settings;
  for (const std::size_t frames : {1, 2, 4, 9}) {
    Setting& setting = settings.emplace_back();
    setting.options = pipeline::default_options();
    setting.name = fmt::format("{} frame{}", frames, frames == 1 ? "" : "s");
    setting.mode = "dp";
    setting.frames = frames;
    setting.is_default = frames == 9;  // as portrait.json has it
  }
  return settings;
}

void run(Setting& setting, const Capture& whole) {
  Capture capture = whole;
  if (setting.frames > 0) capture.frames.resize(std::min(setting.frames, capture.frames.size()));
  std::optional<Image> mask;
  if (setting.options.mode != pipeline::Mode::dp) mask = capture.truth->person_mask;
  pipeline::StoredResult stored;
  stored.mode = setting.mode;
  stored.json = {{"provenance", {{"mode", setting.mode}}}, {"stages", nlohmann::json::array()}};
  const auto portrait = [&] { stored.result = pipeline::run_portrait(capture, setting.options, mask); };
  if (!setting.memory_mb) setting.memory_mb = peak_mb(portrait);
  setting.cpu_ms.push_back(1e3 * cpu_seconds(portrait));
  if (setting.stages.empty()) setting.stages = stored.result.stages;
  const Score score = score_result(capture, "capture", stored, "result");
  if (!score.disparity.empty() && score.disparity.front().rmse_affine_px) {
    setting.disparity_dp_px.push_back(*score.disparity.front().rmse_affine_px);
  }
  if (score.portrait && score.portrait->psnr_srgb_db) {
    setting.portrait_percent.push_back(percent_of_white(*score.portrait->psnr_srgb_db));
  }
}

ChartSection section_of(const std::string& title, const std::string& note, const std::string& unit,
                        const std::vector<Setting>& settings, std::vector<double> Setting::*error) {
  ChartSection section{title, note, unit, "CPU ms", {}};
  for (const Setting& setting : settings) {
    if ((setting.*error).empty()) continue;
    section.points.push_back(
        {setting.name, mean_of(setting.*error), mean_of(setting.cpu_ms), setting.is_default, setting.memory_mb});
  }
  return section;
}

/// Of the mode that is chosen by default.
ChartBar time_bar(const std::vector<Setting>& settings, const std::string& note) {
  const Setting& chosen =
      *std::find_if(settings.begin(), settings.end(), [](const Setting& setting) { return setting.is_default; });
  ChartBar bar{"Where the time goes: " + chosen.name, note + " Wall time of the first capture.", "ms", {}};
  for (const pipeline::StageTime& stage : chosen.stages) bar.parts.emplace_back(stage.name, stage.ms);
  return bar;
}

/// What each cause adds to the square error of mode dp+seg, by leaving truth out one by one.
ChartBar error_bar(const Capture& capture, const std::string& note) {
  constexpr double kUnit = 1e4;
  ChartBar bar{"Where the error comes from: portrait against the true photograph",
               note +
                   " Mean square difference in sRGB of the first capture, as truth is replaced step by step: renderer "
                   "(all else true), the phone's own picture, smoothing of true disparity, disparity as matched by the "
                   "paper's matcher (with its lens's field curvature, which the photograph has not), its scale and "
                   "offset, the mask.",
               "10⁻⁴ of white²",
               {}};
  double before = 0;
  for (const AblationStep& step : measure_defocus(capture, "").steps) {
    const double square = kUnit * std::pow(10, -step.psnr.all_db / 10);
    bar.parts.emplace_back(step.name, square - before);
    before = square;
  }
  return bar;
}

}  // namespace

ChartPart measure_pipeline(const ChartInput& input) {
  const int seeds = input.quick ? 3 : 6;
  std::vector<Setting> modes = mode_settings(), frames = frame_settings();
  std::vector<std::vector<Trial>> defocus, masks;
  std::string size;
  ChartPart part;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Capture capture = read_capture(chart_capture(input, seed), true);
    size = fmt::format("{} x {}", capture.camera.width_px, capture.camera.height_px);
    const Image picture = pipeline::run_portrait(capture).input;  // what is made once is made before the clock runs
    for (std::vector<Setting>* settings : {&modes, &frames}) {
      for (Setting& setting : *settings) run(setting, capture);
    }
    defocus.push_back(try_defocus(capture));
    masks.push_back(try_masks(capture, picture));
    if (!masks.back().empty()) keep_for_bf16(input, seed, picture, capture.truth->person_mask);
    if (seed > 1) continue;
    const std::string one = fmt::format("A burst of portrait.json, {} photosites.", size);
    part.bars = {time_bar(modes, one), error_bar(capture, one)};
  }
  const std::string bursts =
      fmt::format("Bursts of portrait.json, {} photosites; means and standard errors over seeds 1 to {}.", size, seeds);
  const std::string note =
      bursts + " Masks are the true ones; finding people is not in the time. Memory is that of seed 1.";
  part.sections = {
      section_of("Whole pipeline: portrait",
                 note + " Error: RMS difference from the true photograph in sRGB, of white.", "%", modes,
                 &Setting::portrait_percent),
      section_of("Whole pipeline: disparity", note + " Error: RMSE after the affine fit, AIWE(2).", "DP px", modes,
                 &Setting::disparity_dp_px),
      section_of("Burst merge", note + " Mode dp; error: RMSE of disparity after the affine fit.", "DP px", frames,
                 &Setting::disparity_dp_px),
      {"Defocus",
       bursts + " The true all-in-focus picture, blurred with true disparity and mask; error: RMS difference from the "
                "true photograph in sRGB, of white.",
       "%", "CPU ms", points_of(defocus)}};
  const std::string mode_reason =
      "what the paper does where a person is seen, with the matcher of the least error on real pairs (Matchers, "
      "below).";
  part.sections[0].default_reason = part.sections[1].default_reason = mode_reason;
  part.sections[2].default_reason = "as many frames as the scene shoots.";
  part.sections[3].default_reason = "five bands, as the paper has.";
  if (!masks.front().empty()) {
    const Bf16Masks bf16 = try_bf16(input, seeds);
    for (std::size_t i = 0; i < bf16.trials.size(); ++i) masks[i].push_back(bf16.trials[i]);
    if (bf16.trials.empty()) part.left_out.push_back(bf16.left_out);
    part.sections.push_back(
        {"Person mask",
         bursts +
             " From the merged picture, the network on one core, in f32 with AVX2 alone, so that bytes are the same "
             "everywhere, and by another process in bf16 with all that the processor has; faces are found in f32 "
             "in both. Error: 100 % − IoU with the true mask at the picture's size.",
         "%", "CPU ms", points_of(masks)});
    part.sections.back().default_reason = "unfiltered where disparity is known, as the paper has it; mode seg filters.";
  }
  for (ChartSection& section : part.sections) {
    for (int seed = 1; seed <= seeds; ++seed) section.seeds.push_back(seed);
  }
  return part;
}

ChartPart measure_pipeline_growth(const ChartInput& input) {
  ChartGrowth growth{"Whole pipeline: growth with photosites",
                     "Mode dp+seg on bursts of portrait.json of nine frames, the true mask given: the fastest of three "
                     "runs of each stage, wall time with all threads. The paper's point is theirs, of a phone's eight "
                     "cores in 2018: denoised views, disparity and renderer of Table 4, without the burst's merge.",
                     "photosites",
                     "ms",
                     {}};
  ChartGrowth memory{
      "Memory: growth with photosites",
      "The most that is held besides what was held before. Simulator: loading portrait.json, rendering a "
      "burst of nine frames of a hand at rest with its truth, and the capture itself. Pipeline: mode "
      "dp+seg on it, the capture not counted.",
      "photosites",
      "MB",
      {{"simulator", {}}, {"pipeline", {}}}};
  for (const int width : {336, 672, 1344, 2688}) {
    std::vector<std::string> fields = of_width(width);
    fields.insert(fields.end(), {"burst.hand_shake=0", "render.samples_per_pixel=4",
                                 "render.photograph_samples_per_pixel=1", "render.all_in_focus_samples_per_pixel=1"});
    const double photosites = width * (width * 3.0 / 4);
    Capture capture;
    const double simulator_mb =
        peak_mb([&] { capture = simulate_scene(input.scenes_folder + "/portrait.json", fields); });
    memory.lines[0].second.emplace_back(photosites, simulator_mb);
    pipeline::PortraitOptions options = pipeline::default_options();
    options.mode = pipeline::Mode::dp_seg;
    const double pipeline_mb = peak_mb([&] { pipeline::run_portrait(capture, options, capture.truth->person_mask); });
    memory.lines[1].second.emplace_back(photosites, pipeline_mb);
    for (int repeat = 0; repeat < 3; ++repeat) {
      const auto stages = pipeline::run_portrait(capture, options, capture.truth->person_mask).stages;
      growth.lines.resize(stages.size());
      for (std::size_t i = 0; i < stages.size(); ++i) {
        auto& [name, points] = growth.lines[i];
        name = stages[i].name;
        if (repeat == 0) points.emplace_back(photosites, stages[i].ms);
        points.back().second = std::min(points.back().second, stages[i].ms);
      }
    }
  }
  std::vector<std::pair<double, double>> together = growth.lines.front().second;
  for (std::size_t line = 1; line < growth.lines.size(); ++line) {
    for (std::size_t i = 0; i < together.size(); ++i) together[i].second += growth.lines[line].second[i].second;
  }
  growth.lines.emplace_back("together", together);
  growth.lines.push_back({"the paper's, together", {{2688.0 * 2016, 190 + 817 + 1241}}});
  return {.growths = {growth, memory}};
}

std::string chart_capture(const ChartInput& input, int seed) {
  std::string folder = fmt::format("{}/capture_{}", input.scratch, seed);
  if (!std::filesystem::exists(folder)) write_capture(simulate_burst(input, seed), folder);
  return folder;
}

}  // namespace dualpixel::evaluation
