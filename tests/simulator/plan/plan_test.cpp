#include "simulator/lens/prescription/prescription.h"
#include "simulator/plan/plan_text.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/held_camera.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/effects.h"
#include "simulator/plan/match_error.h"
#include "simulator/plan/pilot_errors.h"
#include "simulator/plan/pilot_renders.h"
#include "simulator/plan/plan.h"
#include "simulator/render/truth.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"
#include "tests/run_program.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator {
namespace {

using namespace testing;

/// A camera at the origin that looks along +z through the phone's thin lens; eight windows of a matcher.
Simulation small_camera() {
  Simulation s;
  s.pose = CameraPose{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  s.lens.thin = {4.442e-3, 1.8, 0.8};
  s.sensor.width_px = 132;
  s.sensor.height_px = 128;
  s.sensor.pixel_pitch_um = 11.2;
  s.render.samples_per_pixel = 12;
  s.render.max_bounces = 3;
  return s;
}

/// A wall at 1 m with a speckle of 6 mm, about a DP pixel.
Scene speckled_wall() {
  Scene scene;
  Texture texture;
  texture.width = texture.height = 128;
  for (int i = 0; i < 128 * 128; ++i) {
    const auto gray = static_cast<std::uint8_t>(40 + hash(7, i) % 200);
    texture.rgba.insert(texture.rgba.end(), {gray, gray, gray, 255});
  }
  scene.textures.push_back(texture);
  Material m = diffuse(1);
  m.double_sided = true;
  m.base_color_texture.texture = 0;
  scene.materials.push_back(m);
  scene.meshes.push_back(make_quad({-0.4f, -0.4f, 1}, {0.8f, 0, 0}, {0, 0.8f, 0}, 0));
  return scene;
}

Scene glowing_wall() {
  Scene scene = speckled_wall();
  scene.materials[0].unlit = true;
  scene.unlit_white_nits = 500;
  return scene;
}

/// No light falls on the wall but what a white wall behind the camera returns: the lamp has a shade at its back.
Scene wall_in_indirect_light() {
  Scene scene = speckled_wall();
  Material white = diffuse(0.8f), black = diffuse(0);
  white.double_sided = black.double_sided = true;
  Material lamp = glowing(200000);
  lamp.double_sided = true;
  scene.materials.insert(scene.materials.end(), {white, black, lamp});
  scene.meshes.push_back(make_quad({-2, -2, -0.5f}, {4, 0, 0}, {0, 4, 0}, 1));
  scene.meshes.push_back(make_quad({0.4f, -0.5f, 0.52f}, {1, 0, 0}, {0, 1, 0}, 2));
  scene.meshes.push_back(make_quad({0.75f, -0.15f, 0.5f}, {0.3f, 0, 0}, {0, 0.3f, 0}, 3));
  return scene;
}

int chosen_bounces(const Plan& p) { return p.bounces[p.chosen.bounce].bounces; }
int chosen_samples(const Plan& p) { return p.samples[p.chosen.sample].samples; }

TEST(Plan, AWallThatShinesNeedsNoBounces) {
  const Plan p = plan(small_camera(), glowing_wall(), 0.02, 1);
  EXPECT_TRUE(p.met);
  EXPECT_EQ(p.windows, 8);
  EXPECT_EQ(p.windows_textured, 8);
  EXPECT_EQ(chosen_bounces(p), 0);
  for (const BounceStep& step : p.bounces) EXPECT_EQ(step.error_dp_px, 0);  // not one path goes on
}

TEST(SlowPlan, IndirectLightNeedsABounce) {
  const Plan p = plan(small_camera(), wall_in_indirect_light(), 0.1, 1);
  ASSERT_TRUE(p.measured);
  EXPECT_EQ(p.bounces[0].lost_windows, p.windows_textured);
  EXPECT_GE(p.bounces[0].error_dp_px, 1);
  EXPECT_EQ(chosen_bounces(p), 1);
  EXPECT_EQ(p.effects[0].lost_windows, 0);  // judged in the light
}

// Later pilots go on with the light that earlier ones found, and nothing changes in them.
TEST(Plan, PilotsShareTheLightTheyFind) {
  const Simulation s = small_camera();
  const Scene scene = wall_in_indirect_light();
  RenderScene world(scene, s.light);
  const PilotRenders pilots(s, world, 1);
  const auto views_of = [&](int light_repeat, bool new_light) {
    const PilotRender pilot = pilots.render(
        {.bounces = 1, .light_spacing_px = 4, .light_repeat = light_repeat, .timed = true, .new_light = new_light});
    EXPECT_TRUE(new_light || pilot.light_seconds == 0);
    return pilot.tiles.at(0);
  };
  const auto is_same = [](const DpViews& a, const DpViews& b) {
    return a.left.data == b.left.data && a.right.data == b.right.data;
  };
  const DpViews first = views_of(3, false);
  const LightCache* const found = world.light_cache.get();
  EXPECT_GT(found->table.points(), 0u);
  EXPECT_FALSE(is_same(views_of(4, false), first));
  EXPECT_TRUE(is_same(views_of(3, false), first));
  EXPECT_EQ(world.light_cache.get(), found);
  EXPECT_TRUE(is_same(views_of(3, true), first));
  EXPECT_NE(world.light_cache.get(), found);
}

// More reflections add to what the same paths find with fewer, so that the difference of two pilots has hardly any
// noise.
TEST(Plan, MoreBouncesAddLight) {
  const Simulation s = small_camera();
  const Scene scene = wall_in_indirect_light();
  RenderScene world(scene, s.light);
  const PilotRenders pilots(s, world, 1);
  for (const double spacing_px : {0.0, 4.0}) {
    const auto left = [&](int bounces) {
      return pilots.render({.bounces = bounces, .light_spacing_px = spacing_px}).tiles.at(0).left;
    };
    const Image few = left(1), more = left(3);
    double added = 0, sum = 0;
    for (std::size_t i = 0; i < few.data.size(); ++i) {
      ASSERT_GE(more.data[i], 0.9999f * few.data[i]) << spacing_px;
      added += more.data[i] - few.data[i], sum += few.data[i];
    }
    EXPECT_GT(added, 0.005 * sum);
  }
}

TEST(Plan, AnAberratedLensWithoutAberrationsIsAThinOne) {
  Simulation s = small_camera();
  s.lens.model.emplace<Aberrations>().image_radius_mm = 1.1;
  const Plan p = plan(s, glowing_wall(), 0.02, 1);
  ASSERT_EQ(p.lenses.size(), 2u);
  EXPECT_LT(p.lenses[0].error_dp_px, 1e-3);
  EXPECT_TRUE(std::holds_alternative<ThinModel>(planned(s, p).lens.model));
}

TEST(Plan, ALensOutOfFocusIsNotReplacedByOneInFocus) {
  Simulation s = small_camera();
  auto& aberrations = s.lens.model.emplace<Aberrations>();
  aberrations.image_radius_mm = 1.1;
  aberrations.focus_um = 20;
  const Plan p = plan(s, glowing_wall(), 0.02, 1);
  // a focus surface dz behind the sensor changes the signed blur diameter by 2 R dz / z_i, and disparity is alpha times
  // that, in DP pixels
  const double blur_m = 2 * s.lens.thin.rim_slope() * 20e-6;
  const double expected = s.lens.split.alpha(s.lens.thin.rim_slope()) * blur_m / (2 * 11.2e-6);
  EXPECT_NEAR(p.lenses[0].error_dp_px, expected, 0.01 * expected);
  EXPECT_TRUE(std::holds_alternative<Aberrations>(planned(s, p).lens.model));
}

TEST(Plan, ShowsWhatElseAThinLensChanges) {
  constexpr double kColor = 0.01, kOffset = 0.3, kFocus_um = 20;
  Simulation s = small_camera();
  s.lens.split.kind = SplitKind::hard;
  auto& aberrations = s.lens.model.emplace<Aberrations>();
  aberrations.image_radius_mm = 1.1;
  aberrations.focus_um = kFocus_um;
  aberrations.lateral_color = {kColor, -kColor};
  aberrations.split_offset = FieldMap{kOffset};
  const LensDifferences d = plan(s, glowing_wall(), 1, 1).lenses[0].differences;
  // red lies 2 c r farther out than blue; over a rectangle the mean of r^2 is (w^2 + h^2) / 12
  EXPECT_NEAR(d.color_shift_px, 2 * kColor * std::sqrt((132 * 132 + 128 * 128) / 12.0), 0.02);
  EXPECT_NEAR(d.picture_shift_px, 0, 1e-3);
  // of a unit disc what lies beside a chord at `offset`, beyond one half
  const double share = (kOffset * std::sqrt(1 - kOffset * kOffset) + std::asin(kOffset)) / M_PI;
  EXPECT_NEAR(d.left_share, share, 0.002);
  EXPECT_NEAR(d.light, 0, 1e-3);
  // behind the focus by so much; a focus surface behind the sensor brings the wall to the other side
  const ThinLens& thin = s.lens.thin;
  const double at_wall_px = thin.pupil_diameter_m() * thin.focal_length_m / (0.8 - thin.focal_length_m) * 0.2 / 11.2e-6;
  const double moved_px = 2 * thin.rim_slope() * kFocus_um * 1e-6 / 11.2e-6;
  EXPECT_NEAR(d.blur_px, std::abs(at_wall_px - moved_px) - at_wall_px, 0.01);
}

TEST(Plan, LessToleranceTakesMoreSamples) {
  Simulation s = small_camera();
  s.burst_frames = 1000000;  // so that the sensor's own noise is no excuse
  const Plan coarse = plan(s, glowing_wall(), 0.08, 1);
  const Plan fine = plan(s, glowing_wall(), 0.0002, 1);
  EXPECT_GT(chosen_samples(fine), chosen_samples(coarse));
  ASSERT_GT(fine.chosen.sample, 0u);
  for (const Plan* p : {&coarse, &fine}) {
    EXPECT_TRUE(p->met);
    EXPECT_LE(p->error_dp_px(p->chosen), p->tolerance_dp_px);
    if (p->chosen.sample > 0) {
      PlanChoice fewer = p->chosen;
      --fewer.sample;
      EXPECT_GT(p->error_dp_px(fewer), p->tolerance_dp_px);
    }
  }
}

TEST(Plan, WithoutTextureBouncesAndSamplesStay) {
  Scene scene = glowing_wall();
  scene.materials[0].base_color_texture.texture = -1;
  Simulation file = small_camera();
  file.lens.diffraction = true;
  file.hand_shake = 1;
  file.exposure_poses = 3;
  const Plan p = plan(file, scene, 0.02, 1);
  EXPECT_FALSE(p.measured);
  EXPECT_EQ(p.windows_textured, 0);
  const Simulation s = planned(file, p);
  EXPECT_EQ(s.render.max_bounces, 3);
  EXPECT_EQ(s.render.samples_per_pixel, 12);
  EXPECT_TRUE(s.lens.diffraction);
  EXPECT_EQ(s.exposure_poses, 3);
  EXPECT_EQ(plan_json(p, true)["effects"].size(), 0u);
  EXPECT_NE(plan_text(p).find("not measured"), std::string::npos);
  EXPECT_NE(plan_text(p).find("Not known whether 0.02 DP px are kept"), std::string::npos);
  EXPECT_TRUE(plan_json(p, true)["tolerance_met"].is_null());
}

TEST(Plan, LooksAtMoreWindowsWhereFewHaveTexture) {
  Simulation file = small_camera();
  file.sensor.width_px = 960;
  file.sensor.height_px = 320;
  file.sensor.pixel_pitch_um = 5;
  file.sensor.dp_downsample_x = file.sensor.dp_downsample_y = 1;
  Scene scene = glowing_wall();
  const auto windows_of = [&] {
    const Plan p = plan(file, scene, 0.02, 1);
    for (const BounceStep& step : p.bounces) EXPECT_EQ(step.lost_windows, 0);  // each in its own tile
    EXPECT_EQ(p.measured, p.windows_textured >= 6);
    return std::pair{p.windows, p.windows_textured};
  };
  constexpr int kAtFirst = 48;  // two in each of 24 tiles
  EXPECT_EQ(windows_of().first, kAtFirst);
  scene.meshes[0] = make_quad({-0.2f, -0.05f, 1}, {0.2f, 0, 0}, {0, 0.12f, 0}, 0);
  const auto [some, textured] = windows_of();
  EXPECT_GT(some, kAtFirst);
  EXPECT_LE(some, 4 * kAtFirst);
  EXPECT_GE(textured, 6);
  scene.meshes[0] = make_quad({-2, -2, 1}, {4, 0, 0}, {0, 4, 0}, 0);
  scene.materials[0].base_color_texture.texture = -1;
  EXPECT_EQ(windows_of(), std::pair(4 * kAtFirst, 0));
  file.sensor.width_px = 300;  // no room for a second tile beside the first one of a cell
  file.sensor.height_px = 96;
  EXPECT_EQ(windows_of(), std::pair(kAtFirst, 0));
}

TEST(Plan, SaysSoWhereNothingReachesTheTolerance) {
  Simulation s = small_camera();
  s.burst_frames = 2000000000;  // so that the sensor's own noise is no excuse
  const Plan p = plan(s, glowing_wall(), 3e-6, 1);
  ASSERT_TRUE(p.measured);
  EXPECT_FALSE(p.met);
  EXPECT_EQ(chosen_samples(p), 65536);
  EXPECT_NE(plan_text(p).find("Nothing reaches 3e-06 DP px"), std::string::npos);
}

// The thin lens, the only one on offer, is exact, but light at points leaves an error that no camera samples take away:
// what is chosen stops where samples no longer tell.
TEST(SlowPlan, GoesNotFarBeyondWhatCanBeReached) {
  Simulation s = small_camera();
  s.burst_frames = 2000000000;  // so that the sensor's own noise is no excuse
  const Plan p = plan(s, wall_in_indirect_light(), 1e-5, 1);
  ASSERT_TRUE(p.measured);
  EXPECT_FALSE(p.met);
  EXPECT_LT(chosen_samples(p), 65536);
  PlanChoice most = p.chosen;
  most.sample = p.samples.size() - 1;
  EXPECT_LE(p.error_dp_px(p.chosen), 1.1 * p.error_dp_px(most));
}

// The matcher's pixels are those of the sensor. The error of a lens's focus is a length on the sensor, so that it is
// twice as many DP pixels where these are half as wide; the least sensor is one window of them.
TEST(SlowPlan, KnowsTheDpPixelsOfTheSensor) {
  Simulation s = small_camera();
  s.lens.model.emplace<Aberrations>().image_radius_mm = 1.1;
  std::get<Aberrations>(s.lens.model).focus_um = 20;
  const double as_paper = plan(s, glowing_wall(), 0.02, 1).lenses[0].error_dp_px;
  s.sensor.dp_downsample_y = 2;
  const Plan square = plan(s, glowing_wall(), 0.02, 1);
  EXPECT_EQ(square.windows, 16);  // two columns of windows where there are four of 16 x 2 photosites a side: 4 x 4
  EXPECT_EQ(square.windows_textured, 16);
  EXPECT_NEAR(square.lenses[0].error_dp_px, as_paper, 1e-9);
  s.sensor.dp_downsample_x = s.sensor.dp_downsample_y = 1;
  const Plan dense = plan(s, glowing_wall(), 0.2, 1);
  EXPECT_NEAR(dense.lenses[0].error_dp_px, 2 * as_paper, 0.01 * as_paper);
  EXPECT_TRUE(dense.measured);
  EXPECT_EQ(least_sensor(s.sensor).width_px, 20);
  EXPECT_EQ(least_sensor(s.sensor).height_px, 16);
}

// Light at points is a step of its own: a scene without any leaves the coarsest, one whose light is sampled has no
// other.
TEST(Plan, KnowsLightAtPoints) {
  const Plan unlit = plan(small_camera(), glowing_wall(), 0.02, 1);
  ASSERT_EQ(unlit.lights.size(), 3u);
  for (const LightStep& step : unlit.lights) EXPECT_EQ(step.error_dp_px, 0);
  EXPECT_EQ(planned(small_camera(), unlit).light.light_spacing_px, 8);
  Simulation s = small_camera();
  s.light.light_spacing_px = 0;
  const Plan sampled = plan(s, glowing_wall(), 0.02, 1);
  ASSERT_EQ(sampled.lights.size(), 1u);
  EXPECT_EQ(planned(s, sampled).light.light_spacing_px, 0);
}

// Half as far apart as the scene file has them is offered, too, and more samples of each: what is chosen is simulated,
// and noise of light counts by both.
TEST(Plan, OffersPointsOfLightCloserThanTheFileHasThem) {
  Scene scene = speckled_wall();
  scene.materials.push_back(glowing(20000));
  scene.materials[1].double_sided = true;
  scene.meshes.push_back(make_quad({0.02f, 0, 0.98f}, {0.01f, 0, 0}, {0, 0.01f, 0}, 1));
  Plan p = plan(small_camera(), scene, 0.1, 1);
  ASSERT_EQ(p.lights.size(), 3u);
  const LightStep &wide = p.lights[0], &as_asked = p.lights[1], &close = p.lights[2];
  EXPECT_EQ(wide.spacing_px, 8);
  EXPECT_EQ(as_asked.spacing_px, 4);
  EXPECT_EQ(close.spacing_px, 2);
  EXPECT_NEAR(wide.error_dp_px, 4 * as_asked.error_dp_px, 1e-12);
  EXPECT_EQ(wide.noise, 2);
  EXPECT_NEAR(as_asked.error_dp_px, 4 * close.error_dp_px, 1e-12);
  EXPECT_GT(close.error_dp_px, 0);
  EXPECT_LE(wide.making, as_asked.making);
  EXPECT_LE(as_asked.making, close.making);
  ASSERT_EQ(p.light_samples.size(), 3u);
  EXPECT_EQ(p.light_samples[0].samples, 64);
  EXPECT_EQ(p.light_samples[2].samples, 1024);
  EXPECT_GT(p.light_samples[0].error_dp_px, 0);
  EXPECT_NEAR(p.light_samples[2].error_dp_px, p.light_samples[0].error_dp_px / 4, 1e-12);
  p.chosen.light = 2, p.chosen.light_samples = 2;
  EXPECT_EQ(planned(small_camera(), p).light.light_spacing_px, 2);
  EXPECT_EQ(planned(small_camera(), p).light.light_samples, 1024);
  for (LightStep& step : p.lights) step.error_dp_px = 0;
  PlanChoice few = p.chosen, wide_and_many = p.chosen;
  few.light = 1, few.light_samples = 0;
  wide_and_many.light = 0, wide_and_many.light_samples = 1;  // twice the noise, and half of that
  EXPECT_NEAR(p.error_dp_px(wide_and_many), p.error_dp_px(few), 1e-12);
  EXPECT_GT(p.error_dp_px(few), p.error_dp_px(p.chosen));
}

/// The error that leaving an effect out would leave, and whether the plan does.
struct LeftOut {
  double error_dp_px;
  bool is;
};
LeftOut left_out(const Plan& p, Effect effect) {
  for (std::size_t i = 0; i < p.effects.size(); ++i) {
    if (p.effects[i].effect == effect) return {p.effects[i].error_dp_px, !p.chosen.effects[i]};
  }
  ADD_FAILURE() << "no such effect";
  return {};
}

// The Airy pattern's radius is 1.22 wavelengths times the f-number: a tenth of a photosite at f/1.8, 12 of them at
// f/200, where no speckle is left.
TEST(Plan, DiffractionCountsBehindASmallStop) {
  Simulation s = small_camera();
  const Plan wide = plan(s, glowing_wall(), 0.02, 1);
  EXPECT_LT(left_out(wide, Effect::diffraction).error_dp_px, 0.005);
  EXPECT_TRUE(left_out(wide, Effect::diffraction).is);
  EXPECT_FALSE(planned(s, wide).lens.diffraction);
  s.lens.thin.f_number = 200;
  s.exposure.time_s *= 10000;
  const Plan small = plan(s, glowing_wall(), 0.02, 1);
  EXPECT_GT(left_out(small, Effect::diffraction).error_dp_px, 0.1);
  EXPECT_FALSE(left_out(small, Effect::diffraction).is);
  EXPECT_TRUE(planned(s, small).lens.diffraction);
  s.lens.diffraction = true;  // whether the scene file has it makes no other plan
  EXPECT_EQ(plan_json(plan(s, glowing_wall(), 0.02, 1), false), plan_json(small, false));
}

// Both views move and blur alike in a hand: disparity does not notice until texture is lost. At scale 1 the camera
// turns by 0.15 mrad in 10 ms, a twentieth of a photosite of 11.2 um; at 500, by 25 of them.
TEST(Plan, MotionInTheHandCountsWhereItBlurs) {
  Simulation s = small_camera();
  EXPECT_EQ(plan(s, glowing_wall(), 0.02, 1).effects.size(), 1u);
  s.hand_shake = 1;
  const Plan steady = plan(s, glowing_wall(), 0.02, 1);
  EXPECT_LT(left_out(steady, Effect::motion_blur).error_dp_px, 0.005);
  EXPECT_EQ(planned(s, steady).exposure_poses, 1);
  s.hand_shake = 500;
  const Plan shaken = plan(s, glowing_wall(), 0.02, 1);
  EXPECT_FALSE(left_out(shaken, Effect::motion_blur).is);
  EXPECT_EQ(planned(s, shaken).exposure_poses, 8);
}

// Bent rays are no model of diffraction at a hard split's edge.
TEST(Plan, DiffractionIsNotOfferedBehindAHardSplit) {
  Simulation s = small_camera();
  s.lens.split.kind = SplitKind::hard;
  EXPECT_TRUE(effects_of(s).empty());
  s.lens.diffraction = true;
  EXPECT_EQ(effects_of(s).size(), 1u);
}

// The poses of animated things are kept: no pilot shows what they do.
TEST(Plan, ThePosesOfAnAnimationStay) {
  Simulation s = small_camera();
  s.hand_shake = 1;
  s.exposure_poses = 4;
  s.animation = true;
  EXPECT_EQ(effects_of(s).size(), 1u);
  EXPECT_EQ(without_effects(s).exposure_poses, 4);
}

// Only a prescription with color has bands: no choice without one counts their error as gone.
TEST(SlowPlan, FilterBandsNeedALensThatKnowsThem) {
  Simulation s = small_camera();
  s.lens = read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/phone_6p_4.2mm_f1.8.json", 0.8);
  ASSERT_EQ(effects_of(s).size(), 2u);
  add(Effect::filter_bands, s, s);  // the file's own settings are kept where nothing speaks against them
  ASSERT_TRUE(has(s, Effect::filter_bands));
  const Plan thin = plan(s, glowing_wall(), 5, 1);  // anything will do
  EXPECT_TRUE(std::holds_alternative<ThinModel>(planned(s, thin).lens.model));
  EXPECT_EQ(plan_text(thin).find("\nfilter bands "), std::string::npos);
  EXPECT_NE(plan_text(thin).find("\nno filter bands "), std::string::npos);
  EXPECT_TRUE(left_out(thin, Effect::filter_bands).is);
  EXPECT_EQ(plan_json(thin, true)["effects"].size(), 2u);
  EXPECT_EQ(plan_json(thin, true)["chosen"]["effects"].size(), 0u);
  Simulation with = without_effects(s);
  EXPECT_FALSE(has(with, Effect::filter_bands));
  add(Effect::filter_bands, s, with);
  EXPECT_EQ(prescription_of(with.lens)->band_samples, 5);
}

// A tile's rows are exposed when the sensor's are.
TEST(HeldCamera, ATileMovesAsItsRowsOfTheSensorDo) {
  Simulation s = small_camera();
  s.hand_shake = 3;
  s.sensor.row_time_us = 50;
  const CameraView whole{glm::mat4(1), prepare_lens(s)};
  SensorGrid part = sensor_grid(s.sensor);
  part.height_px = 16;
  part.principal_point_px.y -= 40;
  const CameraView sensor = held_at(s, whole, 0.02);
  const CameraView tile = held_at(s, {glm::mat4(1), whole.lens.over(part)}, 0.02, 40);
  ASSERT_EQ(tile.row_poses->size(), 16u);
  for (int row = 0; row < 16; ++row) EXPECT_EQ(tile.pose(row), sensor.pose(row + 40));
  EXPECT_NE(tile.pose(0), tile.pose(15));
}

TEST(Plan, IsTheSameForAnyNumberOfThreads) {
  const auto text = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return plan_json(plan(small_camera(), glowing_wall(), 0.05, 3), false).dump();
  };
  EXPECT_EQ(text(1), text(4));
}

TEST(Plan, RefusesASensorSmallerThanAWindow) {
  Simulation s = small_camera();
  s.path = "scene.json";
  s.sensor.width_px = 34;
  try {
    plan(s, glowing_wall(), 0.02, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "scene.json: /sensor: 34 x 128 photosites: a plan needs at least 36 x 64, one matcher's window");
  }
}

// The program

const std::string kScene = "'" DUALPIXEL_SCENES_DIR "/calibration_target.json' ";
const std::string kSmall = "--set sensor.width_px=132 --set sensor.height_px=128 --set sensor.pixel_pitch_um=28 ";

TEST(SlowPlanProgram, PrintsATableOrJsonAndWritesIt) {
  const TemporaryFolder folder;
  const Outcome table = run_program("plan " + kScene + kSmall + "--tolerance-px 0.05");
  EXPECT_EQ(table.status, 0) << table.err;
  EXPECT_NE(table.out.find("Enough for 0.05 DP px: thin lens, 0 bounces, "), std::string::npos) << table.out;
  const Outcome as_json =
      run_program("plan " + kScene + kSmall + "--tolerance-px 0.05 --json -o '" + (folder / "plan.json") + "'");
  EXPECT_EQ(as_json.status, 0) << as_json.err;
  EXPECT_EQ(as_json.out, read_bytes(folder / "plan.json"));
  const nlohmann::json parsed = nlohmann::json::parse(as_json.out);
  EXPECT_EQ(parsed["chosen"]["max_bounces"], 0);
  EXPECT_EQ(parsed["tolerance_met"], true);
  EXPECT_GT(parsed["lens_models"][0]["picture_s"], 0);
}

TEST(SlowPlanProgram, SimulateAutoAppliesItAndRecordsIt) {
  const TemporaryFolder folder;
  const std::string arguments =
      "simulate " + kScene + kSmall +
      "--set burst.frames=1 --set render.photograph_samples_per_pixel=1 --set render.max_bounces=5 --auto "
      "--tolerance-px 0.05 -o ";
  ASSERT_EQ(run_program(arguments + "'" + (folder / "a") + "'").status, 0);
  ASSERT_EQ(run_program(arguments + "'" + (folder / "b") + "' --threads 1").status, 0);
  EXPECT_EQ(read_bytes(folder / "a/capture.json"), read_bytes(folder / "b/capture.json"));
  const nlohmann::json plan_of_capture = nlohmann::json::parse(read_capture(folder / "a", false).provenance.plan);
  EXPECT_EQ(plan_of_capture["chosen"]["max_bounces"], 0);
  EXPECT_EQ(plan_of_capture["tolerance_dp_px"], 0.05);
  // and it differs from what the scene file says
  const int samples = plan_of_capture["chosen"]["samples_per_pixel"];
  ASSERT_EQ(run_program("simulate " + kScene + kSmall +
                        "--set burst.frames=1 --set render.photograph_samples_per_pixel=1 --set render.max_bounces=0 "
                        "--set render.samples_per_pixel=" +
                        std::to_string(samples) +
                        " --set render.light_spacing_px=" + plan_of_capture["chosen"]["light_spacing_px"].dump() +
                        " --set render.light_samples=" + plan_of_capture["chosen"]["light_samples"].dump() + " -o '" +
                        (folder / "c") + "'")
                .status,
            0);
  const auto left = [&](const char* name) { return read_capture(folder / name, false).frames[0].left.data; };
  EXPECT_EQ(left("a"), left("c"));
}

TEST(SlowPlanProgram, BadOptionsGetOneLine) {
  expect_one_line_refusal(run_program("plan nowhere.json"));
  expect_one_line_refusal(run_program("plan"));
  expect_one_line_refusal(run_program("plan " + kScene + "--tolerance-px 0"));
  expect_one_line_refusal(run_program("plan " + kScene + "--tolerance-px fine"));
  expect_one_line_refusal(run_program("plan " + kScene + "--set sensor.width_px=8 --set sensor.height_px=8"));
  expect_one_line_refusal(run_program("plan " + kScene + kSmall + "-o /dev/null/plan.json"));
  const TemporaryFolder folder;
  expect_one_line_refusal(run_program("simulate " + kScene + "-o '" + (folder / "capture") + "' --tolerance-px 0.1"));
}

// The promise

/// A sensor at rest of 208 x 128 photosites, as wide as the scene's own; of a picture of 4:3 the middle rows.
Simulation small_picture(const std::string& path) {
  Simulation s = read_simulation(read_json_file(path), path);
  s.hand_shake = 0;
  const double width_um = s.sensor.pixel_pitch_um * s.sensor.width_px;
  s.sensor.width_px = 208;
  s.sensor.height_px = 128;
  s.sensor.pixel_pitch_um = width_um / s.sensor.width_px;
  return s;
}

/// The same over all that a lens draws; focus as the scene has it, or at 3 m for lenses that cannot focus so near.
Simulation covering(const std::string& scene, const std::string& lens) {
  Simulation s = small_picture(DUALPIXEL_SCENES_DIR "/" + scene + ".json");
  const std::string lens_path = DUALPIXEL_SOURCE_DIR "/lens_models/" + lens + ".json";
  try {
    s.lens = read_lens_file(lens_path, s.lens.thin.focus_distance_m);
  } catch (const InputError&) {
    s.lens = read_lens_file(lens_path, 3);
  }
  const double radius_mm = prescription_of(s.lens) ? prescription_of(s.lens)->image_radius_mm : 3.5;
  s.sensor.pixel_pitch_um = 2e3 * radius_mm / std::hypot(s.sensor.width_px, s.sensor.height_px);
  return s;
}

/// Everything on, behind one of the plan's lenses.
Simulation with_all_effects(const Simulation& file, const Lens& lens) {
  Simulation s = without_effects(file);
  s.lens = lens;
  for (const Effect effect : effects_of(file)) add(effect, file, s);
  return s;
}

/// RMS disparity error of a lens against another one over the depths of a scene, at points that the plan does not use.
double traced_error(const Simulation& s, const Scene& scene, const Lens& lens, const Lens& reference) {
  const RenderScene world(scene);
  const auto camera_with = [&](const Lens& chosen) {
    Simulation other = s;
    other.lens = chosen;
    return place_camera(other, scene);
  };
  const CameraView a = camera_with(lens), b = camera_with(reference);
  const Image depth_m = trace_truth(world, a).depth_m;
  double sum = 0;
  int count = 0;
  for (int y = 5; y < s.sensor.height_px; y += 13) {
    for (int x = 3; x < s.sensor.width_px; x += 13) {
      const auto c = trace_disparity(a.lens, x, y), e = trace_disparity(b.lens, x, y);
      ++count;
      if (e.left_light == 0 || e.right_light == 0) continue;
      sum +=
          std::pow((c.slope_dp_px_m - e.slope_dp_px_m) / depth_m.at(x, y) + c.intercept_dp_px - e.intercept_dp_px, 2);
    }
  }
  return std::sqrt(sum / count);
}

/// What the plan promises for a scene and a lens: the chosen settings' error against a reference with everything on, in
/// windows half a window off the plan's, with other random numbers, and with points of light half as far apart in the
/// reference. Two references: their noise does not count.
/// Where the chosen lens draws the picture elsewhere, or nothing has texture, the two renders cannot be compared window
/// by window; then the lens's own error is traced, and the reference is rendered through the chosen lens.
void keeps_its_promise(const Simulation& s, const std::string& scene_name, const std::string& lens,
                       double tolerance_dp_px, int seeds = 16, bool print_plan = false) {
  const Scene scene = load_scene(s);
  const Plan p = plan(s, scene, tolerance_dp_px, 5);
  const LensStep& step = p.lenses[p.chosen.lens];
  EXPECT_TRUE(p.met) << scene_name << ' ' << lens;
  if (print_plan) std::cout << plan_text(p);

  const bool comparable = p.measured && step.differences.picture_shift_px < 0.1;
  const double lens_error =
      comparable ? 0 : traced_error(s, scene, step.candidate.lens, p.lenses.back().candidate.lens);
  RenderScene world(scene, s.light);
  const auto render = [&](const Simulation& simulated, int bounces, int samples, std::uint64_t seed) {
    const CameraView camera = place_camera(simulated, scene);
    use_light(world, simulated.light, seed);
    return expected_dp_views(render_views(world, camera, {samples, bounces, seed}), s.sensor, s.exposure,
                             camera.lens.lux_per_nit());
  };
  double square = lens_error * lens_error;
  std::size_t count = 0;
  if (p.measured) {
    const Simulation chosen = planned(s, p);
    Simulation full = with_all_effects(s, comparable ? p.lenses.back().candidate.lens : step.candidate.lens);
    full.light.light_spacing_px = std::min(s.light.light_spacing_px, chosen.light.light_spacing_px) / 2;
    std::vector<DpViews> cheap;
    for (int seed = 91; seed < 91 + seeds; ++seed) {
      cheap.push_back(render(chosen, chosen_bounces(p), chosen_samples(p), seed));
    }
    const int samples = std::clamp(2 * chosen_samples(p), 64, 128);
    const DpViews first = render(full, kReferenceBounces, samples, 1001);
    const DpViews second = render(full, kReferenceBounces, samples, 1002);
    double products = 0;
    for (const auto& [x, y] : {std::pair{8, 0}, std::pair{0, 8}, std::pair{8, 8}}) {
      const MatchWindows windows =
          match_windows(first, second, describe_exposure(s.sensor, s.exposure), s.burst_frames, tolerance_dp_px, x, y);
      count += windows.textured.size();
      for (const MatchWindow& w : windows.textured) {
        for (const DpViews& views : cheap) {
          const double at = w.shift_dp_px(views);
          products += (at - w.shift_dp_px(first)) * (at - w.shift_dp_px(second)) / static_cast<double>(cheap.size());
        }
      }
    }
    ASSERT_GT(count, 0u);
    square += products / static_cast<double>(count);
  }
  const double error = std::sqrt(std::max(square, 0.0));
  std::cout << fmt::format("{:<20}{:<31}{:<16}{} bounces{:>5} samples  promised {:.4f}, found {:.4f} in {} windows{}\n",
                           scene_name, lens, step.candidate.name, chosen_bounces(p), chosen_samples(p),
                           p.error_dp_px(p.chosen), error, count,
                           comparable ? "" : fmt::format(", of it {:.4f} traced", lens_error));
  EXPECT_LE(error, tolerance_dp_px) << scene_name << ' ' << lens;
}

constexpr double kDefaultTolerance_dp_px = 0.02;

void keeps_its_promise(const std::string& scene, const std::vector<std::string>& lenses,
                       double tolerance_dp_px = kDefaultTolerance_dp_px) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, lenses.size()),
      [&](const auto& some) {
        for (std::size_t i = some.begin(); i < some.end(); ++i) {
          keeps_its_promise(covering(scene, lenses[i]), scene, lenses[i], tolerance_dp_px);
        }
      },
      tbb::simple_partitioner());
}

const std::vector<std::string> kLenses = {
    "phone_thin_4.4mm_f1.8",         "phone_aberrated_4.4mm_f1.8", "phone_6p_4.2mm_f1.8",
    "phone_7p_4.9mm_f1.85",          "double_gauss_100mm_f5",      "full_frame_50mm_f1.8",
    "full_frame_50mm_f4_dual_pixel", "portrait_100mm_f1.1",        "telephoto_250mm_f5.4"};
/// One of each kind: the promises with all lenses are a sweep.
const std::vector<std::string> kFewLenses = {"phone_thin_4.4mm_f1.8", "phone_aberrated_4.4mm_f1.8",
                                             "phone_6p_4.2mm_f1.8", "full_frame_50mm_f4_dual_pixel"};

TEST(SlowPlan, KeepsItsPromiseInSlantedPlanes) { keeps_its_promise("slanted_planes", kFewLenses); }
TEST(SlowPlan, KeepsItsPromiseAtOcclusionEdges) { keeps_its_promise("occlusion_edges", kFewLenses); }
TEST(SweepPlan, KeepsItsPromiseInSlantedPlanes) { keeps_its_promise("slanted_planes", kLenses); }
TEST(SweepPlan, KeepsItsPromiseAtOcclusionEdges) { keeps_its_promise("occlusion_edges", kLenses); }
TEST(SweepPlan, KeepsItsPromiseOnTheCalibrationTarget) { keeps_its_promise("calibration_target", kLenses); }
TEST(SweepPlan, KeepsItsPromiseInThePortrait) {
  keeps_its_promise("portrait", std::vector<std::string>{"phone_6p_4.2mm_f1.8"});  // the scene's own
}
// Each through the lens that it has. Some take half an hour, so that few seeds are taken. Prints the plans.
class GalleryPlan : public ::testing::TestWithParam<std::string> {};
TEST_P(GalleryPlan, KeepsItsPromise) {
  const TemporaryFolder folder;
  const std::string file = DUALPIXEL_SOURCE_DIR "/scenes/gallery/" + GetParam() + ".json", drawn = folder / GetParam();
  ASSERT_EQ(run_program("scene '" + file + "' -o '" + drawn + "'").status, 0);
  keeps_its_promise(small_picture(drawn + "/scene.json"), GetParam(), "its own", kDefaultTolerance_dp_px, 4, true);
}
std::vector<std::string> gallery() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(DUALPIXEL_SOURCE_DIR "/scenes/gallery")) {
    names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}
INSTANTIATE_TEST_SUITE_P(Sweep, GalleryPlan, ::testing::ValuesIn(gallery()),
                         [](const auto& of_test) { return of_test.param; });

// With all lenses .02 DP px was not done after twenty minutes.
TEST(SweepPlan, KeepsALooserPromiseInThePortrait) { keeps_its_promise("portrait", kLenses, 0.1); }

}  // namespace
}  // namespace dualpixel::simulator
