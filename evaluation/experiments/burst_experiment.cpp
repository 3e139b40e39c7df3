#include "evaluation/experiments/burst_experiment.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>

#include "evaluation/baselines/six_channel_merge.h"
#include "evaluation/failures/atlas_scene.h"
#include "evaluation/methods/disparity_method.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/merge_errors.h"
#include "pipeline/portrait/run_portrait.h"
#include "pipeline/portrait/subject.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostFrames = 15;
constexpr int kBorder_px = 16;  // DP px: windows and tiles are cut short there

/// A card of 96 DP px before a wall, the focus between them; the card moves to the right by so much a frame.
AtlasScene card_before_wall(double lux, double dp_px_a_frame, unsigned draw = 0) {
  constexpr double kBlur = 3, kHalfCard = 48, kInterval_s = 1.0 / 15;
  AtlasScene scene{focused_for(atlas_camera("thin"), 24), draw};
  scene.illumination_lux = lux;
  scene.document["burst"] = {{"frames", kMostFrames}, {"interval_s", kInterval_s}};
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), kBlur);
  const Window all = whole_picture(scene);
  add_surface(scene, add_paint(scene, pink_paint(scene, 1)), {-kHalfCard, kHalfCard, all.top, all.bottom},
              at_blur(scene, -kBlur));
  if (dp_px_a_frame > 0) {
    const float a_frame_m = point_seen_at(scene.camera, dp_px_a_frame, 0, depth_of_blur(scene.camera, -kBlur)).x;
    scene.glb.move_last_node(0, glm::vec3(0), 1, {a_frame_m / static_cast<float>(kInterval_s), 0, 0});
    scene.document["burst"]["animation"] = true;
    scene.document["burst"]["exposure_poses"] = 4;
  }
  return scene;
}

Capture take_still(double lux) { return take_burst(card_before_wall(lux, 0)); }

Capture take_in_hand(double lux) { return take_shaken_burst(lux, 0); }

/// As fast as a hand that is raised in some 1.5 s.
Capture take_arm(double lux) { return take_burst(card_before_wall(lux, 4)); }

/// Lamps on the mains: the light differs by up to a tenth from frame to frame, as of exposures of half a period that
/// drift against it.
Capture take_flicker(double lux) {
  constexpr double kDepth = 0.1, kPeriods = 0.37;  // between frames
  Capture all;
  for (int frame = 0; frame < kMostFrames; ++frame) {
    AtlasScene scene = card_before_wall(lux, 0);
    scene.document["burst"]["frames"] = 1;
    scene.document["render"]["seed"] = frame + 1;
    scene.document["unlit_white_nits"] =
        white_nits(scene) * (1 + kDepth * std::sin(2 * std::numbers::pi * kPeriods * frame));
    Capture one = take_burst(scene);
    if (frame == 0) {
      all = std::move(one);
    } else {
      all.frames.push_back(std::move(one.frames.front()));
    }
  }
  return all;
}

struct Condition {
  const char* name;
  Capture (*take)(double lux);
};
constexpr Condition kConditions[] = {
    {"still", take_still}, {"shake", take_in_hand}, {"arm", take_arm}, {"flicker", take_flicker}};

double error_68(const ViewSample& views, const Image& found) {
  std::vector<double> errors;
  for (int y = kBorder_px; y < found.height - kBorder_px; ++y) {
    for (int x = kBorder_px; x < found.width - kBorder_px; ++x) {
      const double error = std::abs(found.at(x, y) - views.truth_dp_px.at(x, y));
      if (!std::isnan(views.truth_dp_px.at(x, y))) errors.push_back(std::isnan(error) ? INFINITY : error);
    }
  }
  const auto at = errors.begin() + static_cast<std::ptrdiff_t>(0.6827 * static_cast<double>(errors.size() - 1));
  std::nth_element(errors.begin(), at, errors.end());
  return *at;
}

/// The first frames of a burst as a portrait, focused on the card. Empty where another frame than the first is its
/// base.
Image portrait_of(const Capture& burst, int frames) {
  Capture part = burst;
  part.frames.resize(frames);
  pipeline::PortraitOptions options;
  options.tap = pipeline::tapped_region(0.5 * part.camera.width_px, 0.5 * part.camera.height_px, part.camera);
  options.synthetic_noise = false;
  pipeline::PortraitResult result = pipeline::run_portrait(part, options);
  return result.base_frame == 0 ? std::move(result.portrait_srgb) : Image();
}

struct Merged {
  BurstPoint point;
  pipeline::MergedBurst burst;  ///< the pipeline's
};

std::vector<Merged> merged_bursts(const Capture& burst, const std::vector<int>& frames) {
  constexpr double kSquare = 4;  // a square's mean has a quarter of a pixel's noise: 4 sigma of it are one of a pixel's
  const MergeErrors first = merge_errors(first_frame(burst), burst);
  const auto merge_with = [&](const auto& merge, int count, MergeError& error) {
    const std::vector<Frame> part(burst.frames.begin(), burst.frames.begin() + count);
    const std::clock_t start = std::clock();
    pipeline::MergedBurst merged = merge(part, 0, pipeline::align_burst(part, 0, burst.exposure), burst.exposure);
    error.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const MergeErrors errors = merge_errors(merged, burst);
    error.views_kept = errors.views_rms() / first.views_rms();
    error.mosaic_kept = errors.mosaic_rms() / first.mosaic_rms();
    error.ghost_share = errors.squares_beyond(4 * first.views_rms() / kSquare);
    return merged;
  };
  const auto ours = [](const auto&... burst_parts) { return pipeline::merge_burst(burst_parts...); };
  std::vector<Merged> all;
  for (const int count : frames) {
    BurstPoint point;
    point.frames = count;
    merge_with(merge_six_channels, count, point.six_channels);
    pipeline::MergedBurst merged = merge_with(ours, count, point.merge);
    all.push_back({std::move(point), std::move(merged)});
  }
  return all;
}

}  // namespace

Capture take_shaken_burst(double lux, unsigned draw) {
  AtlasScene scene = card_before_wall(lux, 0, draw);
  scene.document["burst"].update({{"hand_shake", 1}, {"exposure_poses", 4}});
  return take_burst(scene);
}

std::vector<BurstPoint> measure_merge(const Capture& burst, const std::vector<int>& frames) {
  std::vector<BurstPoint> points;
  for (Merged& merged : merged_bursts(burst, frames)) points.push_back(std::move(merged.point));
  return points;
}

std::vector<BurstPoint> measure_burst(const Capture& burst, const Capture& registered, const std::vector<int>& frames) {
  const Image reference = portrait_of(registered, static_cast<int>(registered.frames.size()));
  std::vector<BurstPoint> points;
  for (auto& [point, merged] : merged_bursts(burst, frames)) {
    const ViewSample views = merged_views(burst, std::move(merged), point.frames);
    for (const pipeline::Matcher& matcher : pipeline::matchers()) {
      const MethodRun run = method_of(matcher).run(views.left, views.right, views.sensor);
      point.disparity.push_back({std::string(matcher.name), error_68(views, run.found.disparity_dp_px)});
    }
    const Image portrait = portrait_of(burst, point.frames);
    if (!portrait.empty()) point.portrait_db = psnr_db(portrait, reference);
    points.push_back(std::move(point));
  }
  return points;
}

std::vector<BurstSweep> measure_bursts(const std::function<void(double)>& progress) {
  std::vector<BurstSweep> sweeps;
  const std::vector<int> frames(std::begin(kBurstFrames), std::end(kBurstFrames));
  constexpr double kLux[] = {5, 100};
  for (const double lux : kLux) {
    const Capture registered = take_still(lux);
    for (const Condition& condition : kConditions) {
      const Capture burst = condition.take(lux);
      sweeps.push_back({condition.name, lux, measure_burst(burst, registered, frames)});
      if (progress) {
        progress(static_cast<double>(sweeps.size()) / static_cast<double>(std::size(kLux) * std::size(kConditions)));
      }
    }
  }
  return sweeps;
}

Json to_json(const MergeError& error) {
  return {{"error_kept", error.views_kept},
          {"mosaic_error_kept", error.mosaic_kept},
          {"ghost_share", error.ghost_share},
          {"merge_cpu_s", error.cpu_s}};
}

Json to_json(const std::vector<BurstSweep>& sweeps) {
  Json all = Json::array();
  for (const BurstSweep& sweep : sweeps) {
    Json points = Json::array();
    for (const BurstPoint& point : sweep.points) {
      Json json = {{"frames", point.frames}};
      json.update(to_json(point.merge));
      for (const auto& [matcher, error] : point.disparity) json["error_68_percent_dp_px"][matcher] = error;
      json["portrait_db"] = point.portrait_db ? Json(*point.portrait_db) : Json();
      json["six_channels"] = to_json(point.six_channels);
      points.push_back(json);
    }
    all.push_back({{"condition", sweep.condition}, {"light_lux", sweep.lux}, {"points", points}});
  }
  return {{"format", "dualpixel-experiment-burst"}, {"version", 1}, {"bursts", all}};
}

}  // namespace dualpixel::evaluation
