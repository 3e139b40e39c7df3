#include "evaluation/benchmarks/disparity_benchmark.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "capture/image/resample.h"
#include "capture/timing.h"
#include "evaluation/benchmarks/opencv/stereo_peers.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "evaluation/simulated_scene.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/tile_disparity.h"
#include "pipeline/disparity/upsample.h"

namespace dualpixel::evaluation {
namespace {

/// A quarter of the scene's photosites, one frame, 64 samples each: rendering noise is common to both views, and fewer
/// samples would bias every matcher toward 0.
Capture render(const std::string& scene_file) {
  return simulate_scene(scene_file, {"sensor.width_px=1344", "sensor.height_px=1008", "sensor.pixel_pitch_um=2.8",
                                     "sensor.dp_downsample_x=2", "sensor.dp_downsample_y=4", "burst.frames=1",
                                     "render.samples_per_pixel=64", "render.photograph_samples_per_pixel=1",
                                     "render.all_in_focus_samples_per_pixel=1"});
}

double mean_of(const std::vector<double>& curve) {
  return std::accumulate(curve.begin(), curve.end(), 0.0) / static_cast<double>(curve.size());
}

double area_over_oracle(const Sparsification& curves) { return mean_of(curves.error) / mean_of(curves.oracle); }

/// The area over the oracle's if every error were drawn from its predicted sigma: no confidence can say more about an
/// error than its scale.
double area_of_exact_sigma(const std::vector<float>& sigma) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<float> error, confidence;
  for (const float value : sigma) {
    error.push_back(std::abs(value * normal(random)));
    confidence.push_back(-value);
  }
  return area_over_oracle(sparsification(error, confidence));
}

MatcherBenchmark errors_of(const pipeline::PixelDisparity& found, const Image& truth, const Image& valid) {
  std::vector<float> estimate, expected, error, confidence, sigmas;
  double within_one = 0, within_two = 0, pixels = 0, overconfident = 0;
  for (int y = 0; y < found.disparity_dp_px.height; ++y) {
    for (int x = 0; x < found.disparity_dp_px.width; ++x) {
      // truth of the photosite at the DP pixel's center
      const int u = (2 * x + 1) * truth.width / (2 * found.disparity_dp_px.width);
      const int v = (2 * y + 1) * truth.height / (2 * found.disparity_dp_px.height);
      if (valid.at(u, v) != 1) continue;
      pixels += 1;
      const float d = found.disparity_dp_px.at(x, y);
      if (!std::isfinite(d)) continue;
      estimate.push_back(d);
      expected.push_back(truth.at(u, v));
      error.push_back(std::abs(d - truth.at(u, v)));
      if (!found.confidence.empty()) confidence.push_back(found.confidence.at(x, y));
      if (found.sigma_dp_px.empty()) continue;
      const float sigma = found.sigma_dp_px.at(x, y);
      sigmas.push_back(sigma);
      within_one += error.back() < sigma;
      within_two += error.back() < 2 * sigma;
      overconfident += error.back() > kWrongDpPx && sigma < kConfidentDpPx;
    }
  }
  const auto count = static_cast<double>(estimate.size());
  MatcherBenchmark result;
  result.answered_share = count / pixels;
  result.rmse_dp_px = rmse(estimate, expected);
  result.wrong_share = bad_pixel_rate(estimate, expected, kWrongDpPx);
  result.aiwe1_dp_px = aiwe1(estimate, expected);
  if (!confidence.empty()) {
    const Sparsification curves = sparsification(error, confidence);
    result.confidence = {area_over_oracle(curves), curves.ause};
  }
  if (!found.sigma_dp_px.empty()) {
    result.sigma = {area_of_exact_sigma(sigmas), within_one / count, within_two / count, overconfident / count};
  }
  return result;
}

/// At the size of a phone's Bayer plane.
StereoPair enlarged(const StereoPair& pair) {
  constexpr int kWidth = 1344, kHeight = 1008;
  return {resize_bilinear(pair.left, kWidth, kHeight), resize_bilinear(pair.right, kWidth, kHeight), pair.sensor};
}

/// The best of a few. Methods take turns, so that a busy machine slows all.
std::vector<double> times_ms(const std::vector<StereoMethod>& all, const StereoPair& large) {
  constexpr int kRepeats = 9;
  std::vector<double> best(all.size(), std::numeric_limits<double>::infinity());
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      best[i] = std::min(best[i], 1e3 * seconds([&] { all[i].match(large); }));
    }
  }
  return best;
}

double copy_ms() {
  const Image from(1344, 1008, 1, 0.5f);
  Image to = from;
  double best = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < 20; ++repeat) {
    best = std::min(
        best, 1e3 * seconds([&] { std::memcpy(to.data.data(), from.data.data(), from.data.size() * sizeof(float)); }));
  }
  return best;
}

nlohmann::ordered_json to_json(const MatcherBenchmark& m) {
  nlohmann::ordered_json json = {{"method", m.method},          {"ms", m.ms},
                                 {"memory_mb", m.memory_mb},    {"answered_share", m.answered_share},
                                 {"rmse_dp_px", m.rmse_dp_px},  {"wrong_share", m.wrong_share},
                                 {"aiwe1_dp_px", m.aiwe1_dp_px}};
  if (m.confidence) {
    json["sparsification_area_over_oracle"] = m.confidence->area_over_oracle;
    json["ause"] = m.confidence->ause ? nlohmann::ordered_json(*m.confidence->ause) : nullptr;
  }
  if (m.sigma) {
    json["sparsification_area_over_oracle_of_exact_sigma"] = m.sigma->area_of_exact_sigma;
    json["within_one_sigma_share"] = m.sigma->within_one_sigma;
    json["within_two_sigma_share"] = m.sigma->within_two_sigma;
    json["overconfident_error_share"] = m.sigma->overconfident_errors;
  }
  return json;
}

}  // namespace

std::vector<StereoMethod> stereo_methods() {
  std::vector<StereoMethod> all;
  for (const pipeline::Matcher& matcher : pipeline::matchers()) {
    all.push_back({std::string(matcher.name), [&matcher](const StereoPair& pair) {
                     return pipeline::upsample_tiles(matcher.match(pair.left, pair.right, pair.sensor, {}),
                                                     pair.left.width, pair.left.height);
                   }});
  }
  for (StereoMethod& peer : opencv_stereo_methods()) all.push_back(std::move(peer));
  return all;
}

DisparityBenchmark measure_disparity(const std::vector<std::string>& scene_files) {
  const std::vector<StereoMethod> all = stereo_methods();
  DisparityBenchmark benchmark;
  benchmark.copy_ms = copy_ms();
  for (const std::string& file : scene_files) {
    const Capture capture = render(file);
    StereoPair pair{normalized(capture.frames[0].left, capture.exposure),
                    normalized(capture.frames[0].right, capture.exposure),
                    of_camera(pipeline::view_sensor(capture.exposure), capture.camera)};
    const StereoPair large = enlarged(pair);
    const std::vector<double> ms = times_ms(all, large);
    DisparityBenchmark::Scene& scene = benchmark.scenes.emplace_back();
    scene.scene = file;
    for (std::size_t i = 0; i < all.size(); ++i) {
      MatcherBenchmark& row = scene.methods.emplace_back(
          errors_of(all[i].match(pair), capture.truth->disparity_dp_px, capture.truth->valid));
      row.method = all[i].name;
      row.ms = ms[i];
      row.memory_mb = peak_mb([&] { all[i].match(large); });
    }
  }
  return benchmark;
}

nlohmann::ordered_json to_json(const DisparityBenchmark& benchmark) {
  nlohmann::ordered_json json = {{"copy_1344x1008_ms", benchmark.copy_ms}, {"scenes", nlohmann::ordered_json::array()}};
  for (const DisparityBenchmark::Scene& scene : benchmark.scenes) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const MatcherBenchmark& method : scene.methods) rows.push_back(to_json(method));
    json["scenes"].push_back({{"scene", scene.scene}, {"methods", rows}});
  }
  return json;
}

}  // namespace dualpixel::evaluation
