#include "evaluation/experiments/noise_experiment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/metrics/statistics.h"
#include "pipeline/burst/merge.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/tile_disparity.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/sensor/sensor.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::Matcher;
using Json = nlohmann::ordered_json;

constexpr double kGrayReflectance = 0.18, kGrayLevel = 0.108;
constexpr double kLongestExposure_s = 1.0 / 15;

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

/// The target, a texel per 1.4 photosites at every depth, across the whole view; its mean is gray lit by 1 lux.
simulator::Scene target(double depth_m, double pixels_per_radian, std::uint64_t seed) {
  simulator::Scene scene;
  scene.textures = {target_texture(seed)};
  simulator::Material material;
  material.unlit = true;
  material.base_color_texture.texture = 0;
  scene.materials = {material};
  scene.unlit_white_nits = static_cast<float>(kGrayReflectance / 0.5 / M_PI);
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
simulator::ExposureOptions expose_gray(double lux, double lux_per_nit, const simulator::SensorOptions& sensor) {
  const double electrons_per_s = lux * kGrayReflectance / M_PI * lux_per_nit * sensor.electrons_per_lux_s[1];
  const double time_s = std::min(kLongestExposure_s, kGrayLevel * sensor.full_well_e / electrons_per_s);
  return {time_s, 100 * kGrayLevel * sensor.full_well_e / (electrons_per_s * time_s)};
}

/// Disparity of every tile that the border does not cut short.
std::vector<double> match(const Image& left, const Image& right, const Matcher& matcher,
                          const pipeline::ViewSensor& sensor) {
  const pipeline::TileDisparity tiles = matcher.match(left, right, sensor, {});
  std::vector<double> values;
  for (int y = 1; y + 1 < tiles.disparity_dp_px.height; ++y) {
    for (int x = 1; x + 1 < tiles.disparity_dp_px.width; ++x) values.push_back(tiles.disparity_dp_px.at(x, y));
  }
  return values;
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

/// Disparities of a static burst of the target, from its first frame and from all merged.
struct Matched {
  std::vector<double> one, six;
};

/// One entry for each of matchers().
std::vector<Matched> expose_and_match(const Target& target, double lux, simulator::SensorOptions sensor,
                                      std::uint64_t seed) {
  sensor.width_px = target.views.left.width;
  sensor.height_px = target.views.left.height;
  const simulator::ExposureOptions options = expose_gray(lux, target.lux_per_nit, sensor);
  const Exposure exposure = simulator::describe_exposure(sensor, options);
  const Image electrons =
      simulator::expected_electrons(target.views.left, target.views.right, sensor, options, lux * target.lux_per_nit);
  std::vector<Frame> frames;
  for (int i = 0; i < kNoiseFrames; ++i) {
    frames.push_back(simulator::expose(electrons, sensor, options, simulator::hash(seed, i)));
  }
  const pipeline::MergedBurst single = pipeline::align_and_merge({frames.front()}, exposure);
  const pipeline::MergedBurst merged = pipeline::align_and_merge(frames, exposure);
  const double remaining = pipeline::merged_view_variance(kNoiseFrames);
  std::vector<Matched> result;
  const auto of_views = [&](double noise_left) {
    pipeline::ViewSensor views = pipeline::view_sensor(exposure, noise_left);
    views.pixel_height = static_cast<float>(sensor.dp_downsample_y) / static_cast<float>(sensor.dp_downsample_x);
    return views;
  };
  for (const Matcher& matcher : pipeline::matchers()) {
    result.push_back({match(single.left, single.right, matcher, of_views(1)),
                      match(merged.left, merged.right, matcher, of_views(remaining))});
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
          {"frames", kNoiseFrames},
          {"samples_per_pixel", options.samples_per_pixel},
          {"seed", options.seed},
          {"paper_sigma_ratio", {{"at_5_lux", 2.0}, {"brighter", 1.5}}},
          {"light", light},
          {"depth_light_lux", options.depth_lux},
          {"depth", depth}};
}

namespace {

/// Both sensors, without and with a fixed pattern.
std::vector<LightSweep> sweep_light(const NoiseExperimentOptions& options, const std::function<void(double)>& step) {
  const Target target = render_target(options.target_m, options.focus_m, options.width_px, options.height_px,
                                      options.samples_per_pixel, options.seed);
  step(10);
  std::vector<LightSweep> all;
  for (const double prnu : {0.0, options.prnu}) {
    simulator::SensorOptions sensor;
    sensor.prnu = prnu;
    std::vector<LightSweep> sweeps;
    for (const Matcher& matcher : pipeline::matchers()) sweeps.push_back({std::string(matcher.name), prnu, {}});
    for (const double lux : options.light_lux) {
      const std::vector<Matched> first = expose_and_match(target, lux, sensor, simulator::hash(options.seed, 1));
      step(2);
      const std::vector<Matched> second = expose_and_match(target, lux, sensor, simulator::hash(options.seed, 2));
      step(2);
      for (std::size_t i = 0; i < sweeps.size(); ++i) {
        sweeps[i].points.push_back({lux, spread(first[i].one, second[i].one), spread(first[i].six, second[i].six)});
      }
    }
    all.insert(all.end(), sweeps.begin(), sweeps.end());
  }
  return all;
}

std::vector<DepthSweep> sweep_depth(const NoiseExperimentOptions& options, const std::function<void(double)>& step) {
  std::vector<DepthSweep> all;
  for (const double focus_m : options.focus_distances_m) {
    simulator::Lens lens;
    lens.thin = {4.442e-3, 1.8, focus_m};
    // d = S (1/z - 1/D), S in DP px m
    const double slope =
        lens.split.alpha(lens.thin.rim_slope()) * lens.thin.pupil_diameter_m() * lens.thin.image_distance_m() / 2.8e-6;
    std::vector<DepthSweep> sweeps;
    for (const Matcher& matcher : pipeline::matchers()) sweeps.push_back({std::string(matcher.name), focus_m, {}});
    for (const double depth_m : options.depths_m) {
      const std::vector<Matched> matched =
          expose_and_match(render_target(depth_m, focus_m, options.width_px / 2, options.height_px / 2,
                                         options.depth_samples_per_pixel, options.seed),
                           options.depth_lux, {}, simulator::hash(options.seed, 3));
      for (std::size_t i = 0; i < sweeps.size(); ++i) {
        const double sigma = deviation(matched[i].six);
        sweeps[i].points.push_back({depth_m, sigma, sigma * depth_m * depth_m / slope});
      }
      step(1);
    }
    all.insert(all.end(), sweeps.begin(), sweeps.end());
  }
  return all;
}

}  // namespace

NoiseExperiment measure_noise(const NoiseExperimentOptions& options, const std::function<void(double)>& progress) {
  const std::size_t bursts = 2 * options.light_lux.size();
  const std::size_t renders = options.focus_distances_m.size() * options.depths_m.size();
  double done = 0;
  const auto step = [&](double work) {
    done += work;
    if (progress) progress(done / static_cast<double>(4 * bursts + renders + 10));
  };
  NoiseExperiment experiment;
  experiment.light = sweep_light(options, step);
  experiment.depth = sweep_depth(options, step);
  return experiment;
}

}  // namespace dualpixel::evaluation
