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

/// A view without noise, as the sensor bins it: the mean of the green photosites of each DP pixel.
Image clean_view(const Image& photosites, const Camera& camera) {
  Image view(camera.dp_width(), camera.dp_height());
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      float sum = 0;
      int count = 0;
      for (int j = 0; j < camera.dp_downsample_y; ++j) {
        for (int i = 0; i < camera.dp_downsample_x; ++i) {
          if ((i + j) % 2 == 0) continue;  // RGGB: red or blue
          sum += photosites.at(camera.dp_downsample_x * x + i, camera.dp_downsample_y * y + j, 1);
          ++count;
        }
      }
      view.at(x, y) = sum / static_cast<float>(count);
    }
  }
  return view;
}

/// The mosaic without noise: both views' light in each photosite's color, before white balance.
Image clean_mosaic(const Capture& capture) {
  const Truth& truth = *capture.truth;
  Image mosaic(truth.left.width, truth.left.height);
  for (int y = 0; y < mosaic.height; ++y) {
    for (int x = 0; x < mosaic.width; ++x) {
      const int color = x % 2 + y % 2;  // RGGB
      mosaic.at(x, y) = static_cast<float>((truth.left.at(x, y, color) + truth.right.at(x, y, color)) /
                                           capture.exposure.white_balance[color]);
    }
  }
  return mosaic;
}

Image difference(const Image& picture, Image clean) {
  for (std::size_t i = 0; i < clean.data.size(); ++i) clean.data[i] = picture.data[i] - clean.data[i];
  return clean;
}

double inner_rms(const std::vector<const Image*>& pictures, int border_px) {
  double squares = 0, count = 0;
  for (const Image* picture : pictures) {
    for (int y = border_px; y < picture->height - border_px; ++y) {
      for (int x = border_px; x < picture->width - border_px; ++x, ++count) {
        squares += static_cast<double>(picture->at(x, y)) * picture->at(x, y);
      }
    }
  }
  return std::sqrt(squares / count);
}

/// Merged pictures less the clean ones.
struct Errors {
  Image left, right, mosaic;

  Errors(const pipeline::MergedBurst& merged, const Capture& capture)
      : left(difference(merged.left, clean_view(capture.truth->left, capture.camera))),
        right(difference(merged.right, clean_view(capture.truth->right, capture.camera))),
        mosaic(difference(merged.mosaic, clean_mosaic(capture))) {}

  double views_rms() const { return inner_rms({&left, &right}, kBorder_px); }
  double mosaic_rms() const { return inner_rms({&mosaic}, 4 * kBorder_px); }

  /// Share of squares of 4 x 4 whose mean is off by more than `limit`.
  double squares_beyond(double limit) const {
    constexpr int kSide = 4;
    double beyond = 0, count = 0;
    for (const Image* view : {&left, &right}) {
      for (int y = kBorder_px; y + kSide <= view->height - kBorder_px; y += kSide) {
        for (int x = kBorder_px; x + kSide <= view->width - kBorder_px; x += kSide, ++count) {
          double sum = 0;
          for (int i = 0; i < kSide * kSide; ++i) sum += view->at(x + i % kSide, y + i / kSide);
          beyond += std::abs(sum) / (kSide * kSide) > limit;
        }
      }
    }
    return beyond / count;
  }
};

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
  const Errors first(
      {normalized(burst.frames[0].mosaic, burst.exposure), normalized(burst.frames[0].left, burst.exposure),
       normalized(burst.frames[0].right, burst.exposure)},
      burst);
  const auto merge_with = [&](const auto& merge, int count, MergeError& error) {
    const std::vector<Frame> part(burst.frames.begin(), burst.frames.begin() + count);
    const std::clock_t start = std::clock();
    pipeline::MergedBurst merged = merge(part, 0, pipeline::align_burst(part, 0, burst.exposure), burst.exposure);
    error.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const Errors errors(merged, burst);
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
