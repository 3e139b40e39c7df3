// The simulator's hand-held bursts through the pipeline's alignment, judged by the motion in truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/burst/align.h"
#include "pipeline/burst/merge.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel {
namespace {

/// A wall 0.9 m ahead of a camera at the origin (glTF's axes), covered by random cells of four sizes, that shines like
/// gray of reflectance 0.18 lit by `lux`.
simulator::Scene textured_wall(double lux) {
  simulator::Texture texture{1024, 1024};
  for (int y = 0; y < 1024; ++y) {
    for (int x = 0; x < 1024; ++x) {
      double sum = 0;
      for (const int cell : {4, 8, 16, 32}) {
        const auto value = simulator::hash(9, cell, (y / cell) * 1024 + x / cell);
        sum += simulator::unit_float(static_cast<std::uint32_t>(value >> 32)) - 0.5;
      }
      const auto level = static_cast<std::uint8_t>(std::lround(255 * std::clamp(0.5 + 0.3 * sum, 0.0, 1.0)));
      texture.rgba.insert(texture.rgba.end(), {level, level, level, 255});
    }
  }
  simulator::Scene scene =
      simulator::testing::shining_picture(std::move(texture), static_cast<float>(lux * 0.36 / M_PI));
  simulator::Mesh mesh;
  mesh.positions = {{-0.15f, -0.15f, -0.9f}, {0.15f, -0.15f, -0.9f}, {0.15f, 0.15f, -0.9f}, {-0.15f, 0.15f, -0.9f}};
  mesh.uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.object_id = 1;
  scene.meshes = {mesh};
  return scene;
}

/// Six frames, 512 x 384 photosites, 1/15 s apart; gray at 0.108 of the white level.
Capture hand_held(double lux, int seed, int exposure_poses = 1) {
  const double electrons = 3.7 * lux * 15;  // per second, on a green photosite
  const double time_s = std::min(1.0 / 15, 648 / electrons);
  const nlohmann::json document = {
      {"version", 1},
      {"gltf", "none"},
      {"camera", {{"focus_distance_m", 0.9}}},
      {"sensor", {{"width_px", 512}, {"height_px", 384}}},
      {"exposure", {{"time_s", time_s}, {"iso", 100 * 648 / (electrons * time_s)}}},
      {"burst",
       {{"frames", 6},
        {"hand_shake", 1},
        {"hand_shake_seed", seed},
        {"interval_s", 1.0 / 15},
        {"exposure_poses", exposure_poses}}},
      {"render",
       {{"samples_per_pixel", 16}, {"photograph_samples_per_pixel", 1}, {"all_in_focus_samples_per_pixel", 1}}}};
  return simulate(simulator::read_simulation(document, "test.json"), textured_wall(lux));
}

/// The largest of the frames' median errors, Bayer px, over tiles whose content both frames show.
double alignment_error(const Capture& capture) {
  const std::vector<pipeline::MotionField> found = pipeline::align_burst(capture.frames, 0, capture.exposure);
  double worst = 0;
  for (std::size_t frame = 1; frame < found.size(); ++frame) {
    const Image& truth = capture.truth->motion[frame - 1];
    std::vector<double> errors;
    for (int j = 3; j < found[frame].height - 3; ++j) {
      for (int i = 3; i < found[frame].width - 3; ++i) {
        const int x = 2 * pipeline::kMotionStep * i, y = 2 * pipeline::kMotionStep * j;  // photosites
        errors.push_back(std::hypot(found[frame].at(i, j, 0) - truth.at(x, y, 0) / 2,
                                    found[frame].at(i, j, 1) - truth.at(x, y, 1) / 2));
      }
    }
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    worst = std::max(worst, *middle);
  }
  return worst;
}

TEST(SlowRenderedBurst, AlignmentFindsTheTrueMotionAtHundredLux) {
  const double error_px = alignment_error(hand_held(100, 1));
  RecordProperty("median_error_bayer_px", std::to_string(error_px));
  EXPECT_LT(error_px, 0.15);
}

TEST(SlowRenderedBurst, AlignmentFindsTheTrueMotionAtFiveLux) {
  const double error_px = alignment_error(hand_held(5, 2));
  RecordProperty("median_error_bayer_px", std::to_string(error_px));
  EXPECT_LT(error_px, 0.5);
}

// Blur within the exposure is the mean over its poses, centered on the frame's pose: motion stays right.
TEST(SlowRenderedBurst, AlignmentStandsBlurWithinTheExposure) { EXPECT_LT(alignment_error(hand_held(5, 3, 4)), 0.5); }

}  // namespace
}  // namespace dualpixel
