#include "evaluation/experiments/scene_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/image/display.h"
#include "capture/image/resample.h"
#include "capture/json_fields.h"
#include "capture/timing.h"
#include "scenes/drawn/meter.h"
#include "scenes/kinds/kinds.h"
#include "simulator/render/truth.h"
#include "simulator/render/views.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kColumns = 6, kMostOnSheet = 36, kThumbnail_px = 160;
constexpr float kVeil =
    0.02f;  ///< of the picture's mean, added before the logarithm as stray light and black level are

/// Log luminance of each over the same veil.
NoisyPictures log_luminance(const std::vector<Image>& parts) {
  NoisyPictures logs;
  double mean = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    logs[i] = Image(parts[i].width, parts[i].height);
    for (std::size_t k = 0; k < parts[i].pixel_count(); ++k) {
      const float* p = &parts[i].data[3 * k];
      logs[i].data[k] = 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
      mean += logs[i].data[k] / static_cast<double>(4 * parts[i].pixel_count());
    }
  }
  const float veil = std::max(kVeil * static_cast<float>(mean), 1e-12f);
  for (Image& image : logs) {
    for (float& value : image.data) value = std::log(std::max(value, 0.0f) + veil);
  }
  return logs;
}

double log_contrast(const NoisyPictures& logs) {
  double sum = 0, products = 0;
  const auto n = static_cast<double>(logs[0].data.size());
  for (std::size_t k = 0; k < logs[0].data.size(); ++k) {
    sum += 0.5 * (logs[0].data[k] + logs[1].data[k]) / n;
    products += logs[0].data[k] * logs[1].data[k] / n;
  }
  return std::sqrt(std::max(products - sum * sum, 0.0));
}

Image thumbnail_of(const std::vector<Image>& parts, double signal_per_nit) {
  Image sum = parts[0];
  for (std::size_t i = 1; i < parts.size(); ++i) {
    for (std::size_t k = 0; k < sum.data.size(); ++k) sum.data[k] += parts[i].data[k];
  }
  for (float& value : sum.data) value *= static_cast<float>(signal_per_nit / static_cast<double>(parts.size()));
  return encode_for_display(resize_area(sum, kThumbnail_px, kThumbnail_px / 4 * 3), {.exposure_ev = 1});
}

/// Loads the scene, renders four pictures of it, and fills in what they show.
void look_at(const std::string& path, const SceneExperimentOptions& options, DrawnSceneResult& result) {
  const json scene_file = read_json_file(path);
  json small = scenes::small_picture(scene_file, options.width_px);
  json& render_file = small["render"];
  render_file.erase("light_spacing_px");  // light that is kept has far less noise than light that is sampled
  constexpr int kDefault = simulator::LightCacheOptions{}.light_samples;
  // What the scene asks for is kept where the picture is to have as many samples; else seeds would take too long.
  render_file["light_samples"] =
      std::min(render_file.value("light_samples", kDefault), std::max(kDefault, options.samples_per_pixel));
  const simulator::Simulation simulation = simulator::read_simulation(small, path);
  const simulator::Scene scene = simulator::load_scene(simulation);
  result.faults.insert(result.faults.end(), scene.warnings.begin(), scene.warnings.end());
  const simulator::RenderScene world(scene, simulation.light);
  const simulator::CameraView camera = simulator::place_camera(simulation, scene);
  std::vector<Image> parts;
  simulator::RenderOptions render = simulation.render;
  render.samples_per_pixel = options.samples_per_pixel / 4;
  render.ideal_aperture_scale = 0;
  for (int i = 0; i < 4; ++i) {
    render.seed = simulation.render.seed + 1000003 * static_cast<std::uint64_t>(i);
    parts.push_back(simulator::undivided(simulator::render_views(world, camera, render)));
    for (const float value : parts[i].data) {
      if (std::isfinite(value)) continue;  // a sum of few samples may be negative: see carried() of paths.cpp
      result.faults.push_back(fmt::format("a photosite holds {} nits", value));
      break;
    }
  }
  const NoisyPictures logs = log_luminance(parts);
  result.slope = amplitude_slope(logs);
  result.gradients = gradient_moments(logs);
  result.contrast = log_contrast(logs);
  result.thumbnail = thumbnail_of(parts, scenes::signal_per_nit(scene_file));
  const Truth truth = simulator::trace_truth(world, camera);
  for (std::size_t k = 0; k < truth.depth_m.data.size(); ++k) {
    if (truth.valid.data[k] > 0) result.depth_m.push_back(truth.depth_m.data[k]);
  }
  result.rendered = true;
  result.sky = 1 - static_cast<double>(result.depth_m.size()) / static_cast<double>(truth.depth_m.data.size());
}

DrawnSceneResult measure_scene(const SceneExperimentOptions& options, std::uint64_t seed, const std::string& scratch) {
  DrawnSceneResult result;
  result.seed = seed;
  const scenes::SceneKind& kind = scenes::scene_kind(options.kind);
  try {
    result.draw_peak_mb = peak_mb([&] {
      result.draw_s = seconds([&] {
        result.draw_cpu_s = cpu_seconds([&] {
          result.faults = scenes::draw_scene(kind, {options.kind, seed, {}}, scratch);
        });
      });
    });
    result.render_s = seconds([&] { look_at(scratch + "/scene.json", options, result); });
  } catch (const std::exception& error) {
    result.faults.emplace_back(error.what());
  }
  return result;
}

Image sheet_of(const std::vector<DrawnSceneResult>& scenes) {
  const int n = std::min(static_cast<int>(scenes.size()), kMostOnSheet), high = kThumbnail_px / 4 * 3;
  Image sheet(std::min(n, kColumns) * kThumbnail_px, (n + kColumns - 1) / kColumns * high, 3);
  for (int i = 0; i < n; ++i) {
    const Image& picture = scenes[static_cast<std::size_t>(i)].thumbnail;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        for (int c = 0; c < 3; ++c)
          sheet.at(i % kColumns * kThumbnail_px + x, i / kColumns * high + y, c) = picture.at(x, y, c);
      }
    }
  }
  return sheet;
}

/// Median and largest.
template <typename Value>
ordered_json spread(const std::vector<DrawnSceneResult>& scenes, const Value& value) {
  std::vector<double> values;
  for (const DrawnSceneResult& scene : scenes) values.push_back(value(scene));
  return {{"median", quantiles(values)[2]}, {"largest", *std::max_element(values.begin(), values.end())}};
}

/// Shares of all pixels by octaves of depth, from 1/8 m; those of sky are not among them.
ordered_json depth_octaves(const std::vector<DrawnSceneResult>& scenes) {
  ordered_json rows = ordered_json::array();
  double pixels = 0;
  for (const DrawnSceneResult& scene : scenes)
    pixels += static_cast<double>(scene.depth_m.size()) / std::max(1 - scene.sky, 1e-9);
  for (int octave = -3; octave < 7; ++octave) {
    const double from = std::exp2(octave), to = std::exp2(octave + 1);
    double count = 0;
    for (const DrawnSceneResult& scene : scenes)
      count += static_cast<double>(std::count_if(scene.depth_m.begin(), scene.depth_m.end(),
                                                 [&](float depth) { return depth >= from && depth < to; }));
    rows.push_back({{"from_m", from}, {"to_m", to}, {"share", count / std::max(pixels, 1.0)}});
  }
  return rows;
}

bool was_rendered(const DrawnSceneResult& scene) { return scene.rendered; }

/// Means over what was rendered.
ordered_json statistics(const std::vector<DrawnSceneResult>& scenes) {
  std::vector<double> slopes, contrasts, kurtoses, depths, ranges;
  GradientMoments pooled;
  double sky = 0;
  const auto n = static_cast<double>(std::count_if(scenes.begin(), scenes.end(), was_rendered));
  for (const DrawnSceneResult& scene : scenes) {
    if (!scene.rendered) continue;
    if (std::isfinite(scene.slope)) slopes.push_back(scene.slope);
    if (scene.gradients.square > 0) kurtoses.push_back(scene.gradients.kurtosis());
    contrasts.push_back(scene.contrast);
    pooled.square += scene.gradients.square / n, pooled.fourth += scene.gradients.fourth / n, sky += scene.sky / n;
    const std::array<double, 5> depth = quantiles({scene.depth_m.begin(), scene.depth_m.end()});
    depths.push_back(depth[2]);
    ranges.push_back(depth[4] / std::max(depth[0], 1e-9));
  }
  return {{"amplitude_slope", quantiles(slopes)},     {"log_contrast", quantiles(contrasts)},
          {"gradient_deviation", pooled.deviation()}, {"gradient_kurtosis_pooled", pooled.kurtosis()},
          {"gradient_kurtosis", quantiles(kurtoses)}, {"median_depth_m", quantiles(depths)},
          {"depth_ratio_95_to_5", quantiles(ranges)}, {"sky", sky},
          {"depth_octaves", depth_octaves(scenes)}};
}

}  // namespace

SceneExperiment measure_scenes(const SceneExperimentOptions& options, const std::string& scratch,
                               const std::function<void(double)>& progress) {
  SceneExperiment experiment;
  for (int i = 0; i < options.count; ++i) {
    const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(i);
    experiment.scenes.push_back(measure_scene(options, seed, scratch));
    if (i >= kMostOnSheet) experiment.scenes.back().thumbnail = Image();
    if (progress) progress((i + 1.0) / options.count);
  }
  experiment.sheet = sheet_of(experiment.scenes);
  return experiment;
}

ordered_json to_json(const SceneExperiment& experiment, const SceneExperimentOptions& options) {
  const std::vector<DrawnSceneResult>& scenes = experiment.scenes;
  ordered_json faults = ordered_json::array();
  for (const DrawnSceneResult& scene : scenes) {
    for (const std::string& fault : scene.faults) faults.push_back({{"seed", scene.seed}, {"fault", fault}});
  }
  return {{"kind", options.kind},
          {"first_seed", options.first_seed},
          {"count", options.count},
          {"width_px", options.width_px},
          {"samples_per_pixel", options.samples_per_pixel},
          {"faults", faults},
          {"draw_cpu_s", spread(scenes, [](const DrawnSceneResult& s) { return s.draw_cpu_s; })},
          {"draw_s", spread(scenes, [](const DrawnSceneResult& s) { return s.draw_s; })},
          {"draw_peak_mb", spread(scenes, [](const DrawnSceneResult& s) { return s.draw_peak_mb; })},
          {"render_s", spread(scenes, [](const DrawnSceneResult& s) { return s.render_s; })},
          {"quantiles", {0.05, 0.25, 0.5, 0.75, 0.95}},
          {"statistics", statistics(scenes)}};
}

}  // namespace dualpixel::evaluation
