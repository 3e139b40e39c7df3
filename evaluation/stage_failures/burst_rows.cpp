#include <cmath>
#include <numbers>

#include "capture/image/display.h"
#include "evaluation/failures/atlas_scene.h"
#include "evaluation/metrics/merge_errors.h"
#include "evaluation/stage_failures/stage_row.h"
#include "pipeline/burst/align.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kBurstLength = 6;
constexpr double kWallBlur = 3;  // DP px
constexpr double kBurstLux = 100;

AtlasScene textured_wall(double lux, unsigned draw) {
  AtlasScene scene{focused_for(atlas_camera("thin"), 24), draw};
  scene.illumination_lux = lux;
  scene.document["burst"] = {{"frames", kBurstLength}, {"exposure_poses", 8}};
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), kWallBlur);
  return scene;
}

/// What was added last moves to the right from the first frame on, and is in its place at `at_s`.
void move_last(AtlasScene& scene, double dp_px_per_s, double blur_dp_px, double at_s = 0) {
  const float m_per_s = point_seen_at(scene.camera, dp_px_per_s, 0, depth_of_blur(scene.camera, blur_dp_px)).x;
  const auto at = static_cast<float>(at_s);
  scene.glb.move_last_node(0, {-m_per_s * at, 0, 0}, 1, {m_per_s * (1 - at), 0, 0});
  scene.document["burst"]["animation"] = true;
}

Image shown_view(const pipeline::MergedBurst& merged) {
  Image rgb(merged.left.width, merged.left.height, 3);
  const float white = 2 * static_cast<float>(kAtlasLevel);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = merged.left.data[i / 3] / white;
  return encode_for_display(rgb);
}

double one_frame_rms(const Capture& capture) { return merge_errors(first_frame(capture), capture).views_rms(); }

pipeline::MergedBurst merged_into_first(const Capture& capture) {
  return pipeline::merge_burst(capture.frames, 0, pipeline::align_burst(capture.frames, 0, capture.exposure),
                               capture.exposure);
}

StageOutcome noise_kept(const Capture& capture) {
  const pipeline::MergedBurst merged = merged_into_first(capture);
  return {merge_errors(merged, capture).views_rms() / one_frame_rms(capture), shown_view(merged)};
}

StageOutcome in_low_light(double lux, unsigned draw) {
  AtlasScene scene = textured_wall(lux, draw);
  scene.document["burst"].update({{"hand_shake", 1}, {"hand_shake_seed", draw + 1}});
  const Capture capture = take_burst(scene);
  const pipeline::MergedBurst merged = merged_into_first(capture);
  double light = 0;
  for (const float value : capture.truth->left.data)
    light += value / static_cast<double>(capture.truth->left.data.size());
  return {merge_errors(merged, capture).views_rms() / light, shown_view(merged)};
}

StageOutcome with_moving_card(double dp_px_a_frame, unsigned draw) {
  constexpr double kHalfCard = 48, kInterval_s = 1.0 / 15;
  AtlasScene scene = textured_wall(kBurstLux, draw);
  const Window all = whole_picture(scene);
  add_surface(scene, add_paint(scene, pink_paint(scene, 1)), {-kHalfCard, kHalfCard, all.top, all.bottom},
              at_blur(scene, -kWallBlur));
  scene.document["burst"]["interval_s"] = kInterval_s;
  if (dp_px_a_frame > 0) move_last(scene, dp_px_a_frame / kInterval_s, -kWallBlur);
  const Capture capture = take_burst(scene);
  const pipeline::MergedBurst merged = merged_into_first(capture);
  // the mean of 4 x 4 pixels has a quarter of one's noise: four deviations of it are one of a pixel
  return {merge_errors(merged, capture).squares_beyond(one_frame_rms(capture)), shown_view(merged)};
}

/// How one frame of a burst of the wall differs from the others.
struct FrameOf {
  double light = 1;       ///< over that of the others
  double blur_dp_px = 0;  ///< by a motion to the right
  double roll_deg = 0;    ///< of the camera
};

Capture take_frame(const FrameOf& frame, int index, unsigned draw) {
  AtlasScene scene = textured_wall(kBurstLux, draw);
  const double roll = frame.roll_deg * std::numbers::pi / 180;
  scene.document["burst"]["frames"] = 1;
  scene.document["render"]["seed"] = kBurstLength * static_cast<int>(draw) + index + 1;
  scene.document["camera"]["up"] = {std::sin(roll), std::cos(roll), 0};
  scene.document["unlit_white_nits"] = white_nits(scene) * frame.light;
  if (frame.blur_dp_px == 0) return take_burst(scene);
  // An animation begins in the middle of the first frame: the second one is blurred throughout.
  constexpr double kSecond_s = 0.1;  // exposures take 1/15 s at most
  scene.document["burst"].update({{"frames", 2}, {"interval_s", kSecond_s}});
  move_last(scene, frame.blur_dp_px / exposure_of(scene).time_s, kWallBlur, kSecond_s);
  Capture capture = take_burst(scene);
  capture.frames.erase(capture.frames.begin());
  capture.truth.reset();  // was that frame's
  return capture;
}

/// The first frame as it should be, and the others as `frame_of` says.
template <typename FrameOfIndex>
Capture take_uneven_burst(unsigned draw, const FrameOfIndex& frame_of) {
  Capture capture = take_frame({}, 0, draw);
  for (int index = 1; index < kBurstLength; ++index) {
    capture.frames.push_back(take_frame(frame_of(index), index, draw).frames.front());
  }
  return capture;
}

StageOutcome with_roll(double degrees, unsigned draw) {
  return noise_kept(take_uneven_burst(draw, [=](int) { return FrameOf{.roll_deg = degrees}; }));
}

StageOutcome in_flickering_light(double depth, unsigned draw) {
  return noise_kept(
      take_uneven_burst(draw, [=](int index) { return FrameOf{.light = 1 + (index % 2 == 0 ? depth : -depth)}; }));
}

/// All frames but one are blurred; the burst is merged into the one that the pipeline chooses.
StageOutcome with_one_sharp_frame(int sharp, double blur_px, unsigned draw) {
  const Capture in_focus = take_frame({}, sharp, draw);
  std::vector<Frame> frames;
  for (int frame = 0; frame < kBurstLength; ++frame) {
    frames.push_back((frame == sharp ? in_focus : take_frame({.blur_dp_px = blur_px}, frame, draw)).frames.front());
  }
  const pipeline::MergedBurst merged = pipeline::align_and_merge(frames, in_focus.exposure);
  return {merge_errors(merged, in_focus).views_rms() / one_frame_rms(in_focus), shown_view(merged)};
}

constexpr const char *kBurst = "burst", *kKept = "error of the views over that of one frame";
constexpr double kHardlyMerged = 0.8, kNoGain = 1;
constexpr const char *kWhyHardly = "Six frames leave as much as a frame and a half would.",
                     *kWhyNoGain = "The sharp frame alone is better.";

std::vector<StageRow> rows_of_light() {
  return {
      {kBurst,
       "low_light",
       "Low light",
       "illumination, lux",
       "illumination_lux",
       {100, 10, 3, 1, 0.3, 0.1},
       "error of the views over their mean",
       kAtlasContrast,
       false,
       "As much noise as the wall has texture.",
       in_low_light,
       true,
       "Six frames of at most 1/15 s in a hand that shakes as measured."},
      {kBurst,
       "flicker",
       "Flickering light",
       "change of the light, brighter and darker in turn, share",
       "share",
       {0, 0.05, 0.1, 0.2, 0.4},
       kKept,
       kHardlyMerged,
       false,
       kWhyHardly,
       in_flickering_light,
       false,
       "The first frame is not changed."},
  };
}

std::vector<StageRow> rows_of_motion() {
  return {
      {kBurst,
       "misalignment",
       "Misalignment",
       "roll of the camera against the first frame, degrees",
       "roll_deg",
       {0, 1, 2, 4, 8, 16},
       kKept,
       kHardlyMerged,
       false,
       kWhyHardly,
       with_roll,
       false,
       "Tiles are found where they went, but not turned. What does not match is not merged: the first frame remains."},
      {kBurst,
       "ghosts",
       "Ghosts of what moves",
       "motion of a card, DP px from frame to frame",
       "dp_px_a_frame",
       {0, 4, 16, 64},
       "share of squares of 4 x 4 px that are off by 4 sigma",
       0.01,
       false,
       "A hundredth of the picture shows something that was not there.",
       with_moving_card,
       false,
       "No value breaks it: tiles that differ are not merged."},
      {kBurst,
       "one_sharp_frame",
       "One sharp frame",
       "motion blur of the other frames, DP px",
       "blur_dp_px",
       {0, 2, 8, 32},
       kKept,
       kNoGain,
       false,
       kWhyNoGain,
       [](double blur, unsigned draw) { return with_one_sharp_frame(1, blur, draw); },
       false,
       "The second frame is sharp. No value breaks it: it is chosen, and the others are left out where they differ."},
      {kBurst,
       "late_sharp_frame",
       "One sharp frame, late",
       "which frame is sharp, of six",
       "frame",
       {1, 3, 4, 6},
       kKept,
       kNoGain,
       false,
       kWhyNoGain,
       [](double frame, unsigned draw) { return with_one_sharp_frame(static_cast<int>(frame) - 1, 8, draw); },
       false,
       "The others are blurred by 8 DP px. The base is the sharpest of the first three frames, as in the paper."},
  };
}

}  // namespace

std::vector<StageRow> burst_rows() {
  std::vector<StageRow> rows = rows_of_motion();
  for (const StageRow& row : rows_of_light()) rows.push_back(row);
  return rows;
}

}  // namespace dualpixel::evaluation
