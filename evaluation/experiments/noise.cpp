#include "evaluation/experiments/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "pipeline/burst/merge.h"
#include "pipeline/disparity/matchers.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/sensor/sensor.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::Matcher;
using Json = nlohmann::ordered_json;

constexpr int kFrames = 6;
constexpr double kGreyReflectance = 0.18, kGreyLevel = 0.108;
constexpr double kLongest_s = 1.0 / 15;

/// Octaves of random cells of equal contrast, as pictures of natural things have them: mean 0.5, deviation 0.18 before
/// clipping.
simulator::Texture target_texture(std::uint64_t seed) {
  simulator::Texture texture{1024, 1024};
  texture.rgba.resize(4 * 1024 * 1024, 255);
  const std::array<int, 5> cells = {2, 4, 8, 16, 32};
  for (int y = 0; y < 1024; ++y) {
    for (int x = 0; x < 1024; ++x) {
      double sum = 0;
      for (const int cell : cells) {
        const auto value = simulator::hash(seed, cell, (y / cell) * 1024 + x / cell);
        sum += simulator::unit_float(static_cast<std::uint32_t>(value >> 32)) - 0.5;
      }
      const double level = 0.5 + 0.18 * sum / std::sqrt(cells.size() / 12.0);
      for (int c = 0; c < 3; ++c) {
        texture.rgba[4 * (1024 * y + x) + c] =
            static_cast<std::uint8_t>(std::lround(255 * std::clamp(level, 0.0, 1.0)));
      }
    }
  }
  keep_decoded(texture);
  return texture;
}

/// The target, a texel per 1.4 photosites at every depth, across the whole view; its mean is grey lit by 1 lux.
simulator::Scene target(double depth_m, double pixels_per_radian, std::uint64_t seed) {
  simulator::Scene scene;
  scene.textures = {target_texture(seed)};
  simulator::Material material;
  material.unlit = true;
  material.base_color_texture.texture = 0;
  scene.materials = {material};
  scene.unlit_white_nits = static_cast<float>(kGreyReflectance / 0.5 / M_PI);
  const auto texels = static_cast<float>(1.4 * depth_m / pixels_per_radian);  // m
  const float side = 4096 * texels;                                           // the texture four times
  simulator::Mesh mesh;
  const float z = static_cast<float>(depth_m);
  mesh.positions = {
      {-side / 2, -side / 2, z}, {side / 2, -side / 2, z}, {side / 2, side / 2, z}, {-side / 2, side / 2, z}};
  mesh.uv0 = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.object_id = 1;
  scene.meshes = {mesh};
  return scene;
}

/// Views of the target lit by 1 lux, and what turns them into electrons.
struct Target {
  simulator::Views views;
  double lux_per_nit = 0;
};

Target render_target(double depth_m, double focus_m, int width_px, int height_px, int samples, std::uint64_t seed) {
  simulator::Lens lens;
  lens.thin = {4.442e-3, 1.8, focus_m};
  const double pitch_m = 1.4e-6;
  const simulator::CameraView camera{
      glm::mat4(1), simulator::LensSampler(lens, {width_px, height_px, pitch_m, {0.5 * width_px, 0.5 * height_px}})};
  const simulator::Scene scene = target(depth_m, lens.thin.image_distance_m() / pitch_m, seed);
  const simulator::RenderScene world(scene);
  return {simulator::render_views(world, camera, {samples, 0, seed}), camera.lens.lux_per_nit()};
}

/// As automatic exposure would have it.
simulator::ExposureOptions expose_grey(double lux, double lux_per_nit, const simulator::SensorOptions& sensor) {
  const double electrons_per_s = lux * kGreyReflectance / M_PI * lux_per_nit * sensor.electrons_per_lux_s[1];
  const double time_s = std::min(kLongest_s, kGreyLevel * sensor.full_well_e / electrons_per_s);
  return {time_s, 100 * kGreyLevel * sensor.full_well_e / (electrons_per_s * time_s)};
}

/// Disparity of every tile that the border does not cut short.
std::vector<double> match(const Image& left, const Image& right, const Matcher& matcher,
                          const pipeline::ViewNoise& noise) {
  const pipeline::TileDisparity tiles = matcher.match(left, right, noise, {});
  std::vector<double> values;
  for (int y = 1; y + 1 < tiles.disparity_dp_px.height; ++y) {
    for (int x = 1; x + 1 < tiles.disparity_dp_px.width; ++x) values.push_back(tiles.disparity_dp_px.at(x, y));
  }
  return values;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double robust_deviation(std::vector<double> values) {
  const double centre = median(values);
  for (double& value : values) value = std::abs(value - centre);
  return 1.4826 * median(values);
}

double deviation(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) sum += value, squares += value * value;
  const auto n = static_cast<double>(values.size());
  return std::sqrt(std::max(squares / n - sum / n * (sum / n), 0.0));
}

DisparitySpread spread(const std::vector<double>& first, const std::vector<double>& second) {
  std::vector<double> difference = first;
  for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= second[i];
  DisparitySpread s;
  s.sigma = std::sqrt((std::pow(deviation(first), 2) + std::pow(deviation(second), 2)) / 2);
  s.robust = std::sqrt((std::pow(robust_deviation(first), 2) + std::pow(robust_deviation(second), 2)) / 2);
  s.temporal = robust_deviation(difference) / std::sqrt(2.0);
  s.floor = std::sqrt(std::max(s.robust * s.robust - s.temporal * s.temporal, 0.0));
  return s;
}

/// A static burst of the target, as single frame and merged, matched by the first two of matchers().
struct Matched {
  std::vector<double> one[2], six[2];  ///< of the paper's matcher and of the likelihood one
};

Matched expose_and_match(const Target& target, double lux, simulator::SensorOptions sensor, std::uint64_t seed) {
  sensor.width_px = target.views.left.width;
  sensor.height_px = target.views.left.height;
  const simulator::ExposureOptions options = expose_grey(lux, target.lux_per_nit, sensor);
  const Exposure exposure = simulator::describe_exposure(sensor, options);
  const Image electrons =
      simulator::expected_electrons(target.views.left, target.views.right, sensor, options, lux * target.lux_per_nit);
  std::vector<Frame> frames;
  for (int i = 0; i < kFrames; ++i) {
    frames.push_back(simulator::expose(electrons, sensor, options, simulator::hash(seed, i)));
  }
  const pipeline::MergedBurst single = pipeline::align_and_merge({frames.front()}, exposure);
  const pipeline::MergedBurst merged = pipeline::align_and_merge(frames, exposure);
  const auto left = static_cast<float>(pipeline::merged_view_variance(kFrames));
  const pipeline::ViewNoise noise = pipeline::view_noise(exposure);
  Matched result;
  for (const int i : {0, 1}) {
    const Matcher& matcher = pipeline::matchers()[i];
    result.one[i] = match(single.left, single.right, matcher, noise);
    result.six[i] = match(merged.left, merged.right, matcher, {left * noise.shot, left * noise.read});
  }
  return result;
}

Json to_json(const DisparitySpread& s) {
  return {{"sigma_dp_px", s.sigma},
          {"robust_sigma_dp_px", s.robust},
          {"temporal_sigma_dp_px", s.temporal},
          {"floor_sigma_dp_px", s.floor}};
}

}  // namespace

Json to_json(const NoiseExperiment& experiment, const NoiseExperimentOptions& options) {
  Json light = Json::array(), depth = Json::array();
  for (const LightSweep& sweep : experiment.light) {
    Json points = Json::array();
    for (const LightPoint& p : sweep.points) {
      points.push_back({{"light_lux", p.lux},
                        {"one_frame", to_json(p.one)},
                        {"six_frames", to_json(p.six)},
                        {"sigma_ratio", p.one.sigma / p.six.sigma},
                        {"robust_sigma_ratio", p.one.robust / p.six.robust}});
    }
    light.push_back({{"matcher", sweep.matcher}, {"prnu", sweep.prnu}, {"points", points}});
  }
  for (const DepthSweep& sweep : experiment.depth) {
    Json points = Json::array();
    for (const DepthPoint& p : sweep.points) {
      points.push_back({{"depth_m", p.depth_m}, {"sigma_dp_px", p.sigma_dp_px}, {"depth_sigma_m", p.depth_sigma_m}});
    }
    depth.push_back({{"matcher", sweep.matcher}, {"focus_distance_m", sweep.focus_m}, {"points", points}});
  }
  return {{"format", "dualpixel-experiment-noise"},
          {"version", 1},
          {"target_m", options.target_m},
          {"focus_distance_m", options.focus_m},
          {"frames", kFrames},
          {"samples_per_pixel", options.samples_per_pixel},
          {"seed", options.seed},
          {"paper_sigma_ratio", {{"at_5_lux", 2.0}, {"brighter", 1.5}}},
          {"light", light},
          {"depth_light_lux", options.depth_lux},
          {"depth", depth}};
}

namespace {

template <typename Value>
Series over_light(const std::string& name, const LightSweep& sweep, const Value& value, bool dashed = false) {
  Series series{name, {}, dashed, false};
  for (const LightPoint& p : sweep.points) series.points.emplace_back(p.lux, value(p));
  return series;
}

constexpr const char* kLightLabel = "light on the target, lux";

/// What the ratios consist of, in the figures of the sweep without a fixed pattern.
std::string explanation(const NoiseExperiment& experiment) {
  const double left = std::sqrt(pipeline::merged_view_variance(kFrames));
  std::string text = fmt::format(
      "<p>The merge leaves {:.3f} of one frame's noise in the views: what follows the noise of the pixels has a ratio "
      "of {:.2f}. A floor stays in every burst: matching's own error for each tile's texture, and the sensor's fixed "
      "pattern. In the dimmest and the brightest light:</p>\n<ul>\n",
      left, 1 / left);
  for (const LightSweep& sweep : experiment.light) {
    if (sweep.prnu > 0) continue;
    const LightPoint &dim = sweep.points.front(), &bright = sweep.points.back();
    text += fmt::format(
        "<li>{}: ratio {:.2f} and {:.2f}, without outliers {:.2f} and {:.2f}; of the six frames' error {:.3f} and "
        "{:.3f} DP px change from burst to burst, {:.3f} and {:.3f} stay.</li>\n",
        sweep.matcher, dim.one.sigma / dim.six.sigma, bright.one.sigma / bright.six.sigma,
        dim.one.robust / dim.six.robust, bright.one.robust / bright.six.robust, dim.six.temporal, bright.six.temporal,
        dim.six.floor, bright.six.floor);
  }
  return text + "</ul>\n";
}

/// How many targets that stand in some lens's focus that lens measures with the least error, of both matchers.
std::array<int, 2> best_in_focus(const NoiseExperiment& experiment) {
  std::array<int, 2> count{};
  for (const DepthSweep& sweep : experiment.depth) {
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
      if (sweep.points[i].depth_m != sweep.focus_m) continue;
      count[sweep.matcher == "paper" ? 0 : 1] +=
          std::all_of(experiment.depth.begin(), experiment.depth.end(), [&](const DepthSweep& other) {
            return other.matcher != sweep.matcher || other.points[i].depth_sigma_m >= sweep.points[i].depth_sigma_m;
          });
    }
  }
  return count;
}

}  // namespace

std::string to_page(const NoiseExperiment& experiment, const NoiseExperimentOptions& options) {
  std::string body = fmt::format(
      "<h1>Noise of disparity</h1>\n<p>A textured target at {:g} m, the lens focused at {:g} m, the central quarter of "
      "the field; the standard deviation over tiles of 8 x 8 DP pixels of a disparity that is the same everywhere. The "
      "paper (Wadhwa et al. 2018, supplement) finds that six merged frames are 2 times less noisy than one at 5 lux, "
      "and "
      "1.5 times in brighter light.</p>\n",
      options.target_m, options.focus_m);
  body += "<h2>Over light</h2>" + explanation(experiment) + "<div class=\"plots\">";
  for (const bool robust : {false, true}) {
    Plot ratio;
    ratio.title = robust ? "One frame over six, without outliers" : "One frame over six, outliers included";
    ratio.x_label = kLightLabel;
    ratio.y_label = "ratio of standard deviations";
    ratio.log_x = true;
    for (const LightSweep& sweep : experiment.light) {
      ratio.series.push_back(over_light(
          fmt::format("{}{}", sweep.matcher, sweep.prnu > 0 ? ", fixed pattern" : ""), sweep,
          [&](const LightPoint& p) { return robust ? p.one.robust / p.six.robust : p.one.sigma / p.six.sigma; },
          sweep.prnu > 0));
    }
    body += svg_plot(ratio);
  }
  for (const LightSweep& sweep : experiment.light) {
    Plot plot;
    plot.title = fmt::format("Standard deviation, matcher {}{}", sweep.matcher,
                             sweep.prnu > 0 ? fmt::format(", fixed pattern of {:g} %", 100 * sweep.prnu) : "");
    plot.x_label = kLightLabel;
    plot.y_label = "DP px";
    plot.log_x = plot.log_y = true;
    plot.series = {
        over_light("one frame", sweep, [](const LightPoint& p) { return p.one.sigma; }),
        over_light("six frames", sweep, [](const LightPoint& p) { return p.six.sigma; }),
        over_light(
            "six, without outliers", sweep, [](const LightPoint& p) { return p.six.robust; }, true),
        over_light(
            "... changing from burst to burst", sweep, [](const LightPoint& p) { return p.six.temporal; }, true),
        over_light(
            "... staying: floor", sweep, [](const LightPoint& p) { return p.six.floor; }, true)};
    body += svg_plot(plot);
  }
  body += "</div><h2>Over depth</h2>";
  const auto [of_paper, of_likelihood] = best_in_focus(experiment);
  body += fmt::format(
      "<p>Six frames at {:g} lux, outliers included. The target's texture keeps its size in the picture. Depth's error "
      "is "
      "disparity's times D^2 over the slope. Of the {} targets that stand where one of the lenses is focused, that "
      "lens "
      "measures {} best by the paper's matcher and {} by likelihood.</p><div class=\"plots\">",
      options.depth_lux, options.focus_distances_m.size(), of_paper, of_likelihood);
  for (const Matcher& row : pipeline::matchers()) {
    const std::string matcher(row.name);
    Plot disparity, depth;
    disparity.title = "Disparity, matcher " + matcher;
    disparity.y_label = "DP px";
    depth.title = "Depth, matcher " + matcher;
    depth.y_label = "mm";
    for (Plot* plot : {&disparity, &depth}) {
      plot->x_label = "depth of the target, m";
      plot->log_y = plot == &depth;
    }
    for (const DepthSweep& sweep : experiment.depth) {
      if (sweep.matcher != matcher) continue;
      Series of_disparity{fmt::format("focus {:g} m", sweep.focus_m), {}}, of_depth = of_disparity;
      for (const DepthPoint& p : sweep.points) {
        of_disparity.points.emplace_back(p.depth_m, p.sigma_dp_px);
        of_depth.points.emplace_back(p.depth_m, 1e3 * p.depth_sigma_m);
      }
      disparity.series.push_back(of_disparity);
      depth.series.push_back(of_depth);
    }
    body += svg_plot(disparity) + svg_plot(depth);
  }
  body += "</div>";
  return html_page("Noise of disparity", std::string(kReportStyle) + kPlotStyle, body);
}

NoiseExperiment measure_noise(const NoiseExperimentOptions& options, const std::function<void(double)>& progress) {
  NoiseExperiment experiment;
  const std::size_t bursts = 2 * options.light_lux.size();
  const std::size_t renders = options.focus_distances_m.size() * options.depths_m.size();
  double done = 0;
  const auto step = [&](double work) {
    done += work;
    if (progress) progress(done / static_cast<double>(4 * bursts + renders + 10));
  };

  const Target target = render_target(options.target_m, options.focus_m, options.width_px, options.height_px,
                                      options.samples_per_pixel, options.seed);
  step(10);
  for (const double prnu : {0.0, options.prnu}) {
    simulator::SensorOptions sensor;
    sensor.prnu = prnu;
    LightSweep sweeps[2] = {{"paper", prnu, {}}, {"likelihood", prnu, {}}};
    for (const double lux : options.light_lux) {
      const Matched first = expose_and_match(target, lux, sensor, simulator::hash(options.seed, 1));
      step(2);
      const Matched second = expose_and_match(target, lux, sensor, simulator::hash(options.seed, 2));
      step(2);
      for (int i : {0, 1}) {
        sweeps[i].points.push_back({lux, spread(first.one[i], second.one[i]), spread(first.six[i], second.six[i])});
      }
    }
    experiment.light.insert(experiment.light.end(), std::begin(sweeps), std::end(sweeps));
  }

  for (const double focus_m : options.focus_distances_m) {
    simulator::Lens lens;
    lens.thin = {4.442e-3, 1.8, focus_m};
    // d = S (1/z - 1/D), S in DP px m
    const double slope =
        lens.split.alpha(lens.thin.rim_slope()) * lens.thin.pupil_diameter_m() * lens.thin.image_distance_m() / 2.8e-6;
    DepthSweep sweeps[2] = {{"paper", focus_m, {}}, {"likelihood", focus_m, {}}};
    for (const double depth_m : options.depths_m) {
      const Matched matched =
          expose_and_match(render_target(depth_m, focus_m, options.width_px / 2, options.height_px / 2,
                                         options.depth_samples_per_pixel, options.seed),
                           options.depth_lux, {}, simulator::hash(options.seed, 3));
      for (int i : {0, 1}) {
        const double sigma = deviation(matched.six[i]);
        sweeps[i].points.push_back({depth_m, sigma, sigma * depth_m * depth_m / slope});
      }
      step(1);
    }
    experiment.depth.insert(experiment.depth.end(), std::begin(sweeps), std::end(sweeps));
  }
  return experiment;
}

}  // namespace dualpixel::evaluation
