// Disparity beside a sky that is blown out: what clips in one view at its own white level must not be matched.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/tile_disparity.h"
#include "pipeline/portrait/run_portrait.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel {
namespace {

constexpr int kWidth = 512, kHeight = 384;  // photosites; the wall's edge lies in the middle

/// A wall of random cells 0.5 m ahead of a camera at the origin, its right edge on the axis; behind it a plane that
/// shines with `sky_nits`.
simulator::Scene wall_before_sky(float sky_nits) {
  simulator::Texture texture{1024, 1024};
  for (int y = 0; y < 1024; ++y) {
    for (int x = 0; x < 1024; ++x) {
      double sum = 0;
      for (const int cell : {8, 16, 32}) {
        const auto value = simulator::hash(9, cell, (y / cell) * 1024 + x / cell);
        sum += simulator::unit_float(static_cast<std::uint32_t>(value >> 32)) - 0.5;
      }
      const auto level = static_cast<std::uint8_t>(std::lround(255 * std::clamp(0.35 + 0.4 * sum, 0.0, 1.0)));
      texture.rgba.insert(texture.rgba.end(), {level, level, level, 255});
    }
  }
  simulator::Scene scene = simulator::testing::shining_picture(std::move(texture), 600);
  scene.materials.push_back(simulator::testing::glowing(sky_nits));
  scene.meshes = {simulator::testing::make_quad({-0.1f, -0.05f, -0.5f}, {0.1f, 0, 0}, {0, 0.1f, 0}, 0),
                  simulator::testing::make_quad({-5, -5, -4}, {10, 0, 0}, {0, 10, 0}, 1)};
  return scene;
}

Capture wall_capture(float sky_nits, double focus_m) {
  const nlohmann::json document = {
      {"version", 1},
      {"gltf", "none"},
      {"camera", {{"focus_distance_m", focus_m}}},
      {"sensor", {{"width_px", kWidth}, {"height_px", kHeight}}},
      {"exposure", {{"time_s", 0.004}}},
      {"burst", {{"frames", 1}}},
      {"render",
       {{"samples_per_pixel", 64}, {"photograph_samples_per_pixel", 1}, {"all_in_focus_samples_per_pixel", 1}}}};
  return simulate(simulator::read_simulation(document, "test.json"), wall_before_sky(sky_nits));
}

/// Of the tiles of the wall in the four columns next to its edge: the share that is trusted (confidence 1/2 and more),
/// and the share that is trusted and off by more than a quarter of a DP pixel.
struct Trust {
  double trusted = 0, wrong = 0;

  /// Standard error of a share of the eighty tiles of two scenes.
  static double error(double share) { return std::sqrt(share * (1 - share) / 80); }

  void add_half(const Trust& other) { trusted += other.trusted / 2, wrong += other.wrong / 2; }
};

Trust trust_beside_sky(const Capture& capture, const pipeline::Matcher& matcher, const pipeline::ViewSensor& sensor) {
  const Frame& frame = capture.frames[0];
  const pipeline::TileDisparity tiles =
      matcher.match(normalized(frame.left, capture.exposure), normalized(frame.right, capture.exposure), sensor, {});
  const double truth = capture.truth->disparity_dp_px.at(kWidth / 4, kHeight / 2);
  const int edge = kWidth / 4 / tiles.tile_px;  // first column right of it
  Trust trust;
  const double share = 1.0 / (4 * (tiles.disparity_dp_px.height - 2));
  for (int row = 1; row + 1 < tiles.disparity_dp_px.height; ++row) {
    for (int column = edge - 4; column < edge; ++column) {
      if (tiles.confidence.at(column, row) < 0.5f) continue;
      trust.trusted += share;
      trust.wrong += std::abs(tiles.disparity_dp_px.at(column, row) - truth) > 0.25 ? share : 0;
    }
  }
  return trust;
}

// A sky 30 times as bright as a view's white, and one of 8 times before stronger blur. What is wrong although it is
// left out lies in the sky's own blur, whose unclipped rim covers the wall with more light than its own: at most 0.15
// of the tiles (docs/disparity.md). All bounds are two standard errors of a share of the ten rows of four columns in
// two scenes.
TEST(SlowBlownSky, MatchersTrustLittleOfWhatClips) {
  const Capture captures[] = {wall_capture(30000, 0.9), wall_capture(8000, 1.6)};
  for (const pipeline::Matcher& matcher : pipeline::matchers()) {
    Trust own, as_the_mosaic;
    for (const Capture& capture : captures) {
      pipeline::ViewSensor sensor = pipeline::view_sensor(capture.exposure);
      EXPECT_NEAR(sensor.white, 0.5, 1e-6);
      own.add_half(trust_beside_sky(capture, matcher, sensor));
      sensor.white = 1;
      as_the_mosaic.add_half(trust_beside_sky(capture, matcher, sensor));
    }
    EXPECT_LT(own.wrong, 0.15 + 2 * Trust::error(0.15)) << matcher.name;
    EXPECT_GT(own.trusted, 0.5 - 2 * Trust::error(0.5)) << matcher.name;
    if (matcher.name == "paper") {
      EXPECT_LE(own.wrong, as_the_mosaic.wrong);  // which trusts little there anyway
    } else {
      const double error = std::hypot(Trust::error(own.wrong), Trust::error(as_the_mosaic.wrong));
      EXPECT_GT(as_the_mosaic.wrong, own.wrong + 2 * error) << matcher.name;
    }
  }
}

/// Light of a small lamp, far beyond white, in the portrait of a capture whose background is blurred as one.
double lamp_light(const Capture& capture, bool recover) {
  pipeline::PortraitOptions options;
  options.mode = pipeline::Mode::seg;
  options.synthetic_noise = false;
  options.defocus.bokeh.recover_highlights = recover;
  options.defocus.mask_blur.radius_px = 40;
  options.defocus.mask_blur.reference_width_px = kWidth;
  const Image person = [] {
    Image mask(kWidth, kHeight);
    std::fill_n(mask.data.begin(), 8, 1.0f);
    return mask;
  }();
  const Image portrait = pipeline::run_portrait(capture, options, person).portrait;
  double light = 0;
  for (int y = kHeight / 2 - 50; y < kHeight / 2 + 50; ++y) {
    for (int x = kWidth / 2 - 50; x < kWidth / 2 + 50; ++x) light += portrait.at(x, y, 1);
  }
  return light;
}

// A lamp, sixteen photosites wide, is made brighter where the wells of a photosite are full: at white, at twice a
// view's white in a picture made of views, and at less where dark current has filled two fifths of the wells, so that
// no channel reaches white by its gain. The factor of clipped pixels is 1.9 and more (highlights.h); half of the lamp's
// at the least are clipped.
TEST(SlowBlownHighlights, AreRecoveredWhereTheWellsAreFull) {
  simulator::Scene scene;
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  scene.materials = {simulator::testing::glowing(1e5)};
  scene.meshes = {simulator::testing::make_quad({-0.0026f, -0.0026f, -1}, {0.0052f, 0, 0}, {0, 0.0052f, 0}, 0)};
  nlohmann::json document = {
      {"version", 1},
      {"gltf", "none"},
      {"camera", {{"focus_distance_m", 1}}},
      {"sensor", {{"width_px", kWidth}, {"height_px", kHeight}}},
      {"exposure", {{"time_s", 0.004}}},
      {"burst", {{"frames", 1}}},
      {"render",
       {{"samples_per_pixel", 16}, {"photograph_samples_per_pixel", 1}, {"all_in_focus_samples_per_pixel", 1}}}};
  const auto gain = [](const Capture& capture) { return lamp_light(capture, true) / lamp_light(capture, false); };
  Capture capture = simulate(simulator::read_simulation(document, "test.json"), scene);
  EXPECT_NEAR(view_white(capture.exposure), 0.5, 1e-6);
  EXPECT_GT(gain(capture), 1.45);
  capture.frames[0].mosaic = {};
  EXPECT_GT(gain(capture), 1.45);
  const double full_well_e = simulator::SensorOptions().full_well_e;
  document["sensor"]["dark_current_e_per_s"] = 0.4 * full_well_e / 0.004;
  capture = simulate(simulator::read_simulation(document, "test.json"), scene);
  EXPECT_NEAR(view_white(capture.exposure), 0.3, 1e-6);
  EXPECT_GT(gain(capture), 1.45);
}

}  // namespace
}  // namespace dualpixel
