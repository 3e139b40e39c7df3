#include "simulator/simulate.h"
#include "simulator/picture_sampling.h"
#include "simulator/render/adaptive.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sensor_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/error.h"
#include "tests/simulator/scene/gltf/gltf_builder.h"
#include "tests/simulator/test_scenes.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

using nlohmann::json;

json minimal() { return {{"version", 1}, {"gltf", "scene.glb"}}; }

/// The message with which reading `document` fails; empty where it does not.
std::string refusal(const json& document) {
  try {
    read_simulation(document, "dir/s.json");
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(SceneFile, DefaultsArePhoneClass) {
  const Simulation s = read_simulation(minimal(), "dir/s.json");
  EXPECT_EQ(s.gltf_path, "dir/scene.glb");
  EXPECT_EQ(s.sensor.width_px, 2688);
  EXPECT_EQ(s.burst_frames, 9);
  EXPECT_NEAR(s.lens.split.alpha(), 0.21, 0.001);
  EXPECT_NEAR(s.lens.thin.pupil_diameter_m(), 2.468e-3, 1e-6);
}

TEST(SceneFile, FocusAtInfinityIsFine) {
  json document = minimal();
  document["camera"]["focus_distance_m"] = "inf";
  const Simulation s = read_simulation(document, "s.json");
  EXPECT_TRUE(std::isinf(s.lens.thin.focus_distance_m));
  EXPECT_DOUBLE_EQ(s.lens.thin.image_distance_m(), s.lens.thin.focal_length_m);
}

TEST(SceneFile, RefusesWhatCannotBeAndNamesIt) {
  struct Case {
    const char* pointer;
    json value;
    std::vector<std::string> named;
  };
  const std::vector<Case> cases = {
      {"/camera/focus_distance_m", 0.004, {"focus_distance_m", "0.004", "focal length"}},
      {"/lens/f_number", 0, {"/lens/f_number", "0"}},
      {"/lens/f_number", -1.8, {"/lens/f_number", "-1.8"}},
      {"/lens/split/k", 0.5, {"/lens/split/k", "0.5"}},
      {"/lens/focal_lenght_mm", 4, {"focal_lenght_mm", "focal_length_mm"}},
      {"/exposure/time_s", -0.01, {"/exposure/time_s", "-0.01"}},
      {"/exposure/iso", 0, {"/exposure/iso", "0"}},
      {"/sensor/width_px", 0, {"/sensor/width_px", "0"}},
      {"/sensor/width_px", 33, {"/sensor/width_px", "33", "even"}},
      {"/sensor/height_px", 34, {"/sensor/height_px", "34", "multiple of 4"}},
      {"/sensor/pixel_pitch_um", -1, {"/sensor/pixel_pitch_um"}},
      {"/sensor/bits", 7, {"/sensor/bits", "7"}},
      {"/sensor/prnu", -0.1, {"/sensor/prnu", "-0.1"}},
      {"/sensor/dp_downsample_y", 1, {"/sensor/dp_downsample_y", "2 x 1"}},
      {"/sensor/full_well_e", 0, {"/sensor/full_well_e"}},
      {"/sensor/well_spill", 1.5, {"/sensor/well_spill", "1.5"}},
      {"/sensor/readout", "both", {"/sensor/readout", "both", "sum_and_left"}},
      {"/sensor/row_noise_dn", -1, {"/sensor/row_noise_dn", "-1"}},
      {"/sensor/hot_pixel_share", 2, {"/sensor/hot_pixel_share", "2"}},
      {"/sensor/dark_current_doubling_c", 0, {"/sensor/dark_current_doubling_c", "0"}},
      {"/sensor/color_matrix", {1, 0, 0, 1, 0, 0, 0, 0, 1}, {"/sensor/color_matrix", "inverse"}},
      {"/sensor/illuminant", {1, 0, 1}, {"/sensor/illuminant", "0"}},
      {"/sensor/illuminant", {1e-300, 1, 1}, {"/sensor/illuminant", "1e-300"}},
      {"/burst/frames", 0, {"/burst/frames", "0"}},
      {"/burst/hand_shake", -1, {"/burst/hand_shake", "-1"}},
      {"/burst/interval_s", 0.005, {"/burst/interval_s", "0.005", "0.01"}},  // shorter than the exposure
      {"/burst/exposure_poses", 0, {"/burst/exposure_poses", "0"}},
      {"/render/samples_per_pixel", 0, {"/render/samples_per_pixel", "0"}},
      {"/environment/model", "moon", {"/environment/model", "moon", "sky"}},
      {"/version", 2, {"/version", "2"}},
      {"/focus", 1, {"/focus"}},
  };
  for (const Case& c : cases) {
    json document = minimal();
    document[json::json_pointer(c.pointer)] = c.value;
    const std::string message = refusal(document);
    EXPECT_FALSE(message.empty()) << c.pointer << " = " << c.value;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_NE(message.find("dir/s.json"), std::string::npos) << message;
    for (const std::string& word : c.named) EXPECT_NE(message.find(word), std::string::npos) << message;
  }
}

TEST(SceneFile, RefusesPicturesBeyondMemory) {
  json document = minimal();
  document["sensor"] = {{"width_px", 8192}, {"height_px", 6400}};
  document["burst"]["frames"] = 1000;
  EXPECT_NE(refusal(document).find("GB"), std::string::npos);
}

TEST(PlaceCamera, NamesTheNearestCamera) {
  Scene scene;
  scene.cameras = {{"main", glm::mat4(1), {}}};
  json document = minimal();
  document["camera"]["node"] = "mainn";
  const Simulation s = read_simulation(document, "s.json");
  try {
    place_camera(s, scene);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'main'"), std::string::npos) << error.what();
  }
  scene.cameras.clear();
  EXPECT_THROW(place_camera(s, scene), InputError);
}

// A wall of known radiance, all the way: the mean digital number is what photometry says, the truth pictures agree
// with the frames, and frames of a burst differ in noise alone.
TEST(Simulate, DigitalNumbersFollowFromNits) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["burst"]["frames"] = 2;
  document["exposure"]["time_s"] = 0.004;
  document["truth"]["photograph_aperture_scale"] = 3;
  const Simulation s = read_simulation(document, "s.json");
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Capture capture = simulate(s, scene);

  const double lux = 500 * M_PI / 4 * std::pow(s.lens.thin.pupil_diameter_m() / s.lens.thin.image_distance_m(), 2);
  const double green_e = lux * 0.004 * 4000;
  const double green_dn = green_e * (1023 - 64) / 6000.0;
  double sum = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      if (cfa_color(x, y) == 1) sum += capture.frames[0].mosaic.at(x, y) - 64.0;
    }
  }
  const double deviation = std::sqrt(capture.exposure.mosaic_noise.shot_dn * green_dn);
  EXPECT_NEAR(sum / 2048, green_dn, 4 * deviation / std::sqrt(2048));
  EXPECT_NEAR(capture.truth->all_in_focus.at(9, 9, 1), green_dn / (1023 - 64), 1e-4);
  EXPECT_NEAR(capture.truth->photograph.at(9, 9, 0), green_dn / (1023 - 64), 1e-4);
  EXPECT_NE(capture.frames[0].mosaic.data, capture.frames[1].mosaic.data);
  EXPECT_NEAR(capture.camera.alpha, 1 / (4 * 1.19), 1e-12);
  EXPECT_NEAR(capture.truth->depth_m.at(5, 5), 1, 1e-6);  // glTF's -z is forward
}

// Each frame of a burst that shakes has its own pose, and the motion that the pose gives. The first frame is that of a
// single picture, and its truth that of the burst that stands still.
TEST(Simulate, RendersEachFrameOfAHandHeldBurstAtItsOwnPose) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["burst"] = {{"frames", 3}, {"hand_shake_seed", 5}};
  document["render"]["samples_per_pixel"] = 4;
  Scene scene;
  scene.materials = {diffuse(0.7f)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(900)}};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Capture still = simulate(read_simulation(document, "s.json"), scene);
  EXPECT_TRUE(still.truth->motion.empty());
  EXPECT_EQ(still.frames[2].camera_from_world, still.frames[0].camera_from_world);
  document["burst"]["frames"] = 1;
  const Capture single = simulate(read_simulation(document, "s.json"), scene);

  document["burst"]["frames"] = 3;
  document["burst"]["hand_shake"] = 1;
  const Simulation simulation = read_simulation(document, "s.json");
  const Capture shaken = simulate(simulation, scene);
  EXPECT_EQ(shaken.frames[0].mosaic.data, single.frames[0].mosaic.data);
  EXPECT_EQ(shaken.truth->depth_m.data, still.truth->depth_m.data);
  ASSERT_EQ(shaken.truth->motion.size(), 2u);
  const double focal_px = simulation.lens.thin.image_distance_m() / 1.4e-6;
  for (int i : {1, 2}) {
    // The wall lies across the axis at 1 m: its middle is seen where pose * (0, 0, 1) lands. World axes: x, -y, -z.
    const Matrix4& pose = shaken.frames[i].camera_from_world;
    const double x = -pose[2] + pose[3], y = -pose[6] + pose[7], z = -pose[10] + pose[11];
    // pixel (31, 31) has its middle half a photosite from the axis
    EXPECT_NEAR(shaken.truth->motion[i - 1].at(31, 31, 0), focal_px * x / z, 0.02);
    EXPECT_NEAR(shaken.truth->motion[i - 1].at(31, 31, 1), focal_px * y / z, 0.02);
    EXPECT_GT(std::abs(focal_px * x / z) + std::abs(focal_px * y / z), 0.5);
  }
  document["burst"]["exposure_poses"] = 2;
  const Capture blurred = simulate(read_simulation(document, "s.json"), scene);
  EXPECT_EQ(blurred.truth->motion[1].data, shaken.truth->motion[1].data);
  EXPECT_NE(blurred.frames[0].mosaic.data, shaken.frames[0].mosaic.data);
}

/// A wall with a step across the picture, under a sky that is bright on one side: noise that needs samples.
Scene step_under_a_sky() {
  Scene scene;
  scene.materials = {diffuse(0.7f)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({0, -5, -0.95f}, {5, 0, 0}, {0, 10, 0}, 0)};
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(900)}};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  return scene;
}

/// Mean over the picture of the product of two pictures' differences from a third.
double mean_product(const Image& a, const Image& b, const Image& mean) {
  double sum = 0;
  for (std::size_t i = 0; i < mean.data.size(); ++i) sum += (a.data[i] - mean.data[i]) * (b.data[i] - mean.data[i]);
  return sum / static_cast<double>(mean.data.size());
}

/// Half the square difference of two frames' left views over the variance that the capture states: mean over the view.
double found_over_stated_noise(const Capture& capture) {
  const Exposure& e = capture.exposure;
  const ImageU16& a = capture.frames[0].left;
  const ImageU16& b = capture.frames[1].left;
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const double difference = static_cast<double>(a.data[i]) - b.data[i];
    const double mean = (a.data[i] + b.data[i]) / 2.0 - e.black_level_dn;
    sum += difference * difference / 2 / (e.dp_noise.shot_dn * mean + e.dp_noise.read_dn2);
  }
  return sum / static_cast<double>(a.data.size());
}

// Frames that are rendered one by one differ by the noise of rendering, too, which is most of it here. The capture
// states what is found between two frames that see the same (so little shake moves nothing by a hundredth of a
// photosite). What is stated comes from 64 probes of two halves, each of which gives a square to 140 %: of that, three
// times. Of frames that share one render the sensor's noise alone is stated.
TEST(Simulate, StatesTheNoiseThatFramesDifferBy) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}, {"dp_downsample_x", 1}, {"dp_downsample_y", 1}};
  document["burst"] = {{"frames", 2}, {"hand_shake", 1e-4}};
  document["exposure"] = {{"time_s", 0.005}};
  const Scene scene = step_under_a_sky();
  for (const json& render : {json{{"samples_per_pixel", 4}}, json{{"noise_fraction", 3}}, json{{"error", 0.01}}}) {
    document["render"] = render;
    document["render"]["light_spacing_px"] = 0;
    const Capture capture = simulate(read_simulation(document, "s.json"), scene);
    EXPECT_NEAR(found_over_stated_noise(capture), 1, 3 * std::sqrt(2.0 / 128)) << render;
    document["burst"]["hand_shake"] = 0;
    const Capture still = simulate(read_simulation(document, "s.json"), scene);
    document["burst"]["hand_shake"] = 1e-4;
    EXPECT_GT(capture.exposure.dp_noise.shot_dn, 3 * still.exposure.dp_noise.shot_dn) << render;
    EXPECT_NEAR(found_over_stated_noise(still), 1, 4 * std::sqrt(2.0 / (64 * 64))) << render;
  }
}

// Where half of the picture is black and the sensor has no read noise, rendering's variance over the sensor's has no
// bound photosite by photosite. Stated is that of the sums: at most twice what is found in the bright half, since the
// black one adds to rendering's alone; so at least a quarter over the whole picture, which gives it to 10 %.
TEST(Simulate, BlackPartsDoNotBlowUpTheStatedNoise) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}, {"read_noise_e", 0}};
  document["sensor"].update({{"dp_downsample_x", 1}, {"dp_downsample_y", 1}});
  document["burst"] = {{"frames", 2}, {"hand_shake", 1e-4}};
  document["exposure"] = {{"time_s", 0.005}};
  document["render"] = {{"error", 0.01}, {"light_spacing_px", 0}};
  Scene scene = step_under_a_sky();
  Material black;
  black.unlit = true;
  black.base_color = {0, 0, 0, 1};
  scene.materials.push_back(black);
  scene.meshes[1].material = 1;
  const double found = found_over_stated_noise(simulate(read_simulation(document, "s.json"), scene));
  EXPECT_GT(found, 0.25 * 0.9);
  EXPECT_LT(found, 1.1);
}

// Frames of a burst in which nothing moves see the same light. What the capture states is what is found against a
// picture of many more samples. So for the other pictures of truth.
TEST(SlowSimulate, StatesTheNoiseOfTruth) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["render"] = {{"samples_per_pixel", 16}, {"light_spacing_px", 0}};
  const Scene scene = step_under_a_sky();
  const auto truth_of = [&](int frames, int samples, int seed) {
    document["burst"]["frames"] = frames;
    document["render"]["samples_per_pixel"] = samples;
    document["render"]["seed"] = seed;
    return *simulate(read_simulation(document, "s.json"), scene).truth;
  };
  const Truth exact = truth_of(1, 1024, 9), one = truth_of(1, 16, 1), nine = truth_of(9, 16, 1);
  const double single = mean_product(one.left, one.left, exact.left);
  EXPECT_EQ(nine.left.data, one.left.data);
  EXPECT_EQ(nine.noise->views, one.noise->views);
  // 64 probes, each of which gives a square to 100 %
  EXPECT_NEAR(one.noise->views / std::sqrt(single), 1, 0.3);
  // Its unit is that of the pictures, in which the light's color is neutral: red and blue, half of the photosites, err
  // by half of what they did. Of 64 squares known to 100 % the share of green is known to some 0.1.
  document["sensor"]["illuminant"] = {2, 1, 2};
  const Truth tinted = truth_of(1, 16, 1);
  EXPECT_NEAR(tinted.noise->photograph / one.noise->photograph, std::sqrt(0.5 + 0.5 / 4), 0.15);
  EXPECT_NEAR(tinted.photograph.at(9, 9, 0), one.photograph.at(9, 9, 0) / 2, 1e-5);
  const auto found = [&](const Image& a, const Image& b) { return std::sqrt(mean_product(a, a, b)); };
  EXPECT_NEAR(one.noise->all_in_focus / found(one.all_in_focus, exact.all_in_focus), 1, 0.3);
  EXPECT_NEAR(one.noise->photograph / found(one.photograph, exact.photograph), 1, 0.3);
}

// What white light looks like has a color, but no brightness: how light is counted does not depend on it.
TEST(Simulate, OnlyTheColorOfTheIlluminantCounts) {
  json document = minimal();
  document["sensor"]["illuminant"] = {0.2, 0.1, 0.05};
  const Simulation s = read_simulation(document, "s.json");
  EXPECT_EQ(s.sensor.illuminant, (std::array<double, 3>{2, 1, 0.5}));
  // an error of the picture, in which white is neutral
  document["render"]["error"] = 0.01;
  const ErrorTarget goal = *goal_of(read_simulation(document, "s.json"), {}, 0.5);
  EXPECT_NEAR(goal.constant[0], 16e-4, 1e-12);
  EXPECT_NEAR(goal.constant[1], 4e-4, 1e-12);
  EXPECT_NEAR(goal.constant[2], 1e-4, 1e-12);
}

// A capture that could not be read again is refused before anything is rendered.
TEST(Simulate, WhatNoCaptureMayHoldIsRefusedBeforeRendering) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 48}, {"pixel_pitch_um", 100}};
  document["lens"] = {{"model", "aberrated"},
                      {"image_radius_mm", 3.5},
                      {"tangential_pupil", {6}},
                      {"sagittal_pupil", {6}},
                      {"falloff", "cos4"}};
  const Simulation s = read_simulation(document, "s.json");
  bool rendered = false;
  const std::string message = message_of<InputError>(
      [&] { simulate(s, step_under_a_sky(), [&](const std::string&, double) { rendered = true; }); });
  EXPECT_TRUE(message.starts_with("s.json: its capture: /camera/lens_shading/relative_light")) << message;
  EXPECT_FALSE(rendered);
}

TEST(Simulate, ACameraInASurfaceIsRefused) {
  json document = minimal();
  document["camera"] = {{"position_m", {0, 0, 0}}, {"look_at_m", {1, 0, 0}}, {"focus_distance_m", 1}};
  document["sensor"] = {{"width_px", 64}, {"height_px", 48}};
  Scene scene = step_under_a_sky();
  scene.meshes = {make_quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0)};
  EXPECT_EQ(message_of<InputError>([&] { simulate(read_simulation(document, "s.json"), scene); }),
            "s.json: /camera: lies in a surface: must look at it from a distance");
}

// With a goal each picture of truth keeps it, and says by tile how well.
TEST(SlowSimulate, KeepsTheGoalInEveryPicture) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["burst"]["frames"] = 1;
  document["render"] = {{"samples_per_pixel", 2048}, {"light_spacing_px", 0}};
  const Scene scene = step_under_a_sky();
  const Truth exact = *simulate(read_simulation(document, "s.json"), scene).truth;
  constexpr double kError = 0.01;
  document["render"] = {{"error", kError}, {"seed", 2}, {"light_spacing_px", 0}};
  const Truth truth = *simulate(read_simulation(document, "s.json"), scene).truth;
  const auto keeps = [&](const Image& picture, const Image& sigma, double noise, const Image& converged) {
    ASSERT_EQ(sigma.data.size(), picture.data.size() / 3);
    const double found = std::sqrt(mean_product(picture, picture, converged));
    EXPECT_LT(found, 1.2 * kError);  // the pilot's sixteen probes of each tile know its error to some per cent
    EXPECT_NEAR(noise / found, 1, 0.3);
  };
  keeps(truth.all_in_focus, truth.all_in_focus_sigma, truth.noise->all_in_focus, exact.all_in_focus);
  keeps(truth.photograph, truth.photograph_sigma, truth.noise->photograph, exact.photograph);
  keeps(truth.left, truth.views_sigma, truth.noise->views, exact.left);
}

/// A wall that the sky lights through blinds: of a few samples of light the error falls slower than of many.
Scene wall_behind_blinds() {
  Scene scene = step_under_a_sky();
  constexpr float kApart = 0.1f;
  for (int i = -40; i < 40; ++i) {
    scene.meshes.push_back(make_quad({-5, kApart * i, 0.5f}, {10, 0, 0}, {0, 0.5f * kApart, 0}, 0));
  }
  return scene;
}

// Light at points takes half of the square error that a goal allows at most, where the error falls slower than few
// samples foretell. Found between two pictures of the same samples, whose light is not. A half photosite of the
// undivided picture may be off by a quarter of the square.
TEST(Simulate, LightAtPointsKeepsItsShareOfTheGoal) {
  constexpr double kNits = 4;
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  const Scene scene = wall_behind_blinds();
  const Simulation s = read_simulation(document, "s.json");
  const CameraView camera = place_camera(s, scene);
  RenderOptions sharp = s.render;
  sharp.ideal_aperture_scale = 0, sharp.samples_per_pixel = 16;
  RenderScene world(scene, s.light);
  prepare_light(s, world, camera, ErrorTarget{.constant = {kNits * kNits, kNits * kNits, kNits * kNits}});
  const LightCacheOptions light = world.light_cache->options;
  const Image one = render_views(world, camera, sharp).left;
  use_light(world, light, 7);
  const Image other = render_views(world, camera, sharp).left;
  const double found = mean_product(one, one, other) / 2, allowed = kNits * kNits / 4;
  // 64 probes, each of which gives a square to 100 %
  EXPECT_LT(found / allowed, 0.5 * (1 + 1 / std::sqrt(64.0)));
}

// Whatever other goals come between, light is found once for each number of its samples, and changes no byte.
TEST(Simulate, FindsLightOnceForPicturesOfTheSameGoal) {
  json document = minimal();
  document["sensor"] = {{"width_px", 32}, {"height_px", 32}};
  document["burst"]["frames"] = 1;
  document["render"] = {{"error", 0.005}};
  const Simulation fine = read_simulation(document, "s.json");
  document["render"]["error"] = 0.5;
  const Simulation coarse = read_simulation(document, "s.json");
  const Scene scene = step_under_a_sky();
  RenderScene world(scene, fine.light);
  const auto take = [&](const Simulation& s) { return simulate(s, world, place_camera(s, scene)); };
  const auto points = [&] {
    std::uint64_t sum = world.light_cache->table.points();
    for (const auto& spare : world.spare_light) sum += spare->table.points();
    return sum;
  };
  const Capture first = take(fine);
  const int samples = world.light_cache->options.light_samples;
  take(coarse);
  EXPECT_LT(world.light_cache->options.light_samples, samples);  // a goal of its own
  EXPECT_TRUE(std::any_of(world.spare_light.begin(), world.spare_light.end(), [&](const auto& spare) {
    return spare->options.light_samples == samples && spare->table.points() > 0;
  }));
  const std::uint64_t found = points();
  const Capture again = take(fine);
  EXPECT_EQ(points(), found);
  take(coarse);
  EXPECT_EQ(points(), found);
  EXPECT_GT(found, 0u);
  EXPECT_EQ(again.truth->left.data, first.truth->left.data);
  EXPECT_EQ(again.truth->photograph.data, first.truth->photograph.data);
  EXPECT_EQ(again.truth->views_sigma.data, first.truth->views_sigma.data);
}

// No time: the fewest samples. Half a minute for a tile that takes a fraction of a second: the most.
TEST(Simulate, SpendsTheTimeItIsGiven) {
  json document = minimal();
  document["sensor"] = {{"width_px", 8}, {"height_px", 8}};
  document["burst"]["frames"] = 1;
  const Scene scene = step_under_a_sky();
  double spent[2], share[2];
  for (int i : {0, 1}) {
    document["render"] = {{"time_budget_s", i * 30.0}, {"photograph_samples_per_pixel", 1}};
    const Capture capture = simulate(read_simulation(document, "s.json"), scene);
    const Image& samples = capture.truth->samples;
    spent[i] = std::accumulate(samples.data.begin(), samples.data.end(), 0.0) / 64;
    share[i] = capture.provenance.noise_fraction_reached.value();
  }
  EXPECT_EQ(spent[0], 16);
  EXPECT_EQ(spent[1], 16384);
  EXPECT_LT(share[1], share[0]);
  document["render"]["error"] = 0.1;
  EXPECT_THROW(read_simulation(document, "s.json"), InputError);
}

// A quarter of the sensor's noise, at an exposure ten times as long a quarter of what is then, relative to the signal,
// three times less noise: more samples. What was spent and what error is left goes into the capture.
TEST(SlowSimulate, SharesSamplesOutByTheSensorsNoise) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["burst"]["frames"] = 1;
  // light sampled by every path, as with light on surfaces the fewest samples would be enough
  document["render"] = {{"noise_fraction", 0.25}, {"photograph_samples_per_pixel", 1}, {"light_spacing_px", 0}};
  Scene scene;
  scene.materials = {diffuse(0.7f)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.meshes.push_back(make_quad({0, -5, -0.95f}, {5, 0, 0}, {0, 10, 0}, 0));  // shades the wall beside it
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(900)}};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  double spent[2];
  for (int i : {0, 1}) {
    document["exposure"]["time_s"] = i == 0 ? 0.002 : 0.02;
    const Capture capture = simulate(read_simulation(document, "s.json"), scene);
    const TemporaryFolder folder;
    write_capture(capture, folder / "capture");
    const Truth truth = *read_capture(folder / "capture", true).truth;
    EXPECT_EQ(truth.samples.data, capture.truth->samples.data);
    EXPECT_EQ(truth.render_sigma.data, capture.truth->render_sigma.data);
    spent[i] = 0;
    double sum = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        spent[i] += truth.samples.at(x, y) / 4096;
        // of half a photosite, before white balance
        const int c = cfa_color(x, y);
        const double range = 1023 - 64, balance = capture.exposure.white_balance[c];
        const double half_dn = truth.all_in_focus.at(x, y, c) / 2 / balance * range;
        const NoiseProfile& noise = capture.exposure.mosaic_noise;
        const double sensor_dn = std::sqrt(noise.shot_dn * half_dn + noise.read_dn2);
        sum += std::pow(truth.render_sigma.at(x, y) / balance * range / sensor_dn, 2) / 4096;
      }
    }
    // What was shared out for the target over the pilot's probes is measured over all photosites, against the noise at
    // an all-in-focus picture of 8 samples: that scatters by the tenth part.
    EXPECT_LT(std::sqrt(sum), 0.25 * 1.1);
    if (spent[i] > 40) {  // otherwise the fewest samples were enough
      EXPECT_GT(std::sqrt(sum), 0.25 * 0.9);
    }
  }
  EXPECT_GT(spent[1], 1.5 * spent[0]);

  document["render"]["error"] = 0.01;
  EXPECT_THROW(read_simulation(document, "s.json"), InputError);
}

/// A wall that glows with 500 nits, a camera in front of it.
Scene glowing_wall() {
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  return scene;
}

// Sixteen poses share sixteen samples: each still sees both halves of the pupil, and the views stay alike.
TEST(Simulate, PosesOfFewSamplesFavourNeitherView) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["burst"] = {{"frames", 1}, {"hand_shake", 0.01}, {"exposure_poses", 16}};
  document["render"] = {{"samples_per_pixel", 16}, {"photograph_samples_per_pixel", 1}};
  const Capture capture = simulate(read_simulation(document, "s.json"), glowing_wall());
  double sum = 0, sum2 = 0;
  const std::size_t count = capture.frames[0].left.data.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double difference = 1.0 * capture.frames[0].left.data[i] - capture.frames[0].right.data[i];
    sum += difference, sum2 += difference * difference;
  }
  const double mean = sum / static_cast<double>(count);
  EXPECT_LE(std::abs(mean),
            3 * std::sqrt((sum2 / static_cast<double>(count) - mean * mean) / static_cast<double>(count)));
}

// The mean of 16 poses of 4 samples each has a sixteenth of the variance of one, and the capture says so.
TEST(Simulate, StatesTheNoiseOfTheMeanOfItsPoses) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}};
  document["render"]["light_spacing_px"] = 0;
  const auto stated = [&](int poses, int samples) {
    document["burst"] = {{"frames", 1}, {"hand_shake", 1e-6}, {"exposure_poses", poses}};
    document["render"]["samples_per_pixel"] = samples;
    return *simulate(read_simulation(document, "s.json"), step_under_a_sky()).provenance.noise_fraction_reached;
  };
  EXPECT_NEAR(stated(16, 64), stated(1, 4) / 4, 1e-9);
}

// What a capture says of its samples counts all poses of an exposure, and the error is that of their mean: for the same
// share of the sensor's noise four independent nets of a quarter of the samples, or a few more.
TEST(SlowSimulate, StatesSamplesAndErrorOfAllPosesTogether) {
  json document = minimal();
  document["sensor"] = {{"width_px", 16}, {"height_px", 16}};
  document["exposure"]["time_s"] = 0.02;
  document["render"] = {{"noise_fraction", 0.15}, {"photograph_samples_per_pixel", 1}, {"light_spacing_px", 0}};
  const Scene scene = step_under_a_sky();
  double spent[2], sigma[2];
  for (int i : {0, 1}) {
    const int poses = i == 0 ? 1 : 4;
    document["burst"] = {{"frames", 1}, {"hand_shake", 1e-6}, {"exposure_poses", poses}};
    const Truth truth = *simulate(read_simulation(document, "s.json"), scene).truth;
    spent[i] = sigma[i] = 0;
    for (const float samples : truth.samples.data) {
      EXPECT_GE(samples, SampleLimits{}.fewest);
      EXPECT_EQ(std::fmod(samples, poses), 0);
      spent[i] += samples / 256;
    }
    for (const float value : truth.render_sigma.data) sigma[i] += value * value / 256;
  }
  EXPECT_GT(spent[0], 64);
  EXPECT_NEAR(sigma[1] / sigma[0], 1, 0.1);  // counts are powers of two: the target is met to some per cent
  EXPECT_GE(spent[1], 0.9 * spent[0]);       // variance falls at least as 1/n: splitting a net gains nothing
}

// Half of the view shines, half is black: the black half sees a share of the mean, which lies between.
TEST(Simulate, GlareSpreadsAShareOfTheLightEvenly) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}, {"pixel_pitch_um", 14}};
  document["burst"]["frames"] = 1;
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {5, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Truth clear = *simulate(read_simulation(document, "s.json"), scene).truth;
  document["lens"]["veiling_glare"] = 0.02;
  const Truth veiled = *simulate(read_simulation(document, "s.json"), scene).truth;
  EXPECT_EQ(clear.left.at(60, 30, 1), 0);
  const double bright = clear.left.at(3, 30, 1);
  EXPECT_NEAR(veiled.left.at(60, 30, 1), 0.02 * 0.5 * bright, 1e-4 * bright);
  EXPECT_NEAR(veiled.right.at(60, 30, 1), 0.02 * 0.5 * bright, 1e-4 * bright);
  EXPECT_NEAR(veiled.left.at(3, 30, 1), bright * (1 - 0.02 + 0.02 * 0.5), 1e-4 * bright);
  EXPECT_EQ(veiled.photograph.data, clear.photograph.data);  // ideal
  document["truth"]["photograph_lens"] = "own";
  const Truth own = *simulate(read_simulation(document, "s.json"), scene).truth;
  const double brightest = own.photograph.at(3, 30, 1);
  EXPECT_NEAR(own.photograph.at(60, 30, 1), 0.01 * brightest, 1e-3 * brightest);
}

// The thin lens opened wide is the ideal one; another file's lens has its own pupil, and the same field of view.
TEST(SlowSimulate, PhotographMayLookThroughALens) {
  json document = minimal();
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}, {"pixel_pitch_um", 14}};
  document["burst"]["frames"] = 1;
  document["camera"]["focus_distance_m"] = 0.5;
  document["render"] = {{"samples_per_pixel", 256}};
  document["truth"]["photograph_aperture_scale"] = 3;
  const Scene scene = step_under_a_sky();
  const Truth ideal = *simulate(read_simulation(document, "s.json"), scene).truth;
  EXPECT_EQ(ideal.photograph_lens, "ideal");
  document["truth"]["photograph_lens"] = "own";
  const Truth own = *simulate(read_simulation(document, "s.json"), scene).truth;
  EXPECT_EQ(own.photograph_lens, "thin lens at f/0.6");
  EXPECT_NEAR(own.photograph_aperture_scale, 3, 1e-9);
  const double noise = std::hypot(ideal.noise->photograph, own.noise->photograph);
  EXPECT_LT(std::sqrt(mean_product(own.photograph, own.photograph, ideal.photograph)), 2 * noise);

  const TemporaryFolder folder;
  write_bytes(folder / "large.json", R"({"version": 1, "name": "large", "focal_length_mm": 13.326, "f_number": 1.8})");
  document["truth"] = {{"photograph_lens", "large.json"}};
  const Truth large = *simulate(read_simulation(document, folder / "s.json"), scene).truth;
  EXPECT_EQ(large.photograph_lens, "large at f/1.8");
  EXPECT_NEAR(large.photograph_aperture_scale, 3, 1e-9);
  EXPECT_LT(std::sqrt(mean_product(large.photograph, large.photograph, ideal.photograph)), 2 * noise);

  document["truth"] = {{"photograph_lens", folder / "large.json"}, {"photograph_aperture_scale", 2}};
  EXPECT_NE(refusal(document).find("/truth/photograph_aperture_scale"), std::string::npos);
  document["truth"] = {{"photograph_lens", "none.json"}};
  EXPECT_NE(refusal(document).find("/truth/photograph_lens: none.json"), std::string::npos) << refusal(document);
  document["truth"] = {{"photograph_lens", "own"}, {"photograph_aperture_scale", 0}};
  EXPECT_NE(refusal(document).find("/truth/photograph_aperture_scale"), std::string::npos);
}

// Through a lens whose red picture is a tenth larger than the green one, and the blue one a tenth smaller, an edge 15
// photosites from the axis in green lies at 16.5 and 13.5 in the others, in every channel of the photograph. 256
// samples know it to a sixteenth of a photosite in each of 64 rows: .008, twice that.
TEST(Simulate, PhotographThroughALensHasItsColors) {
  json document = minimal();
  document["lens"] = {{"model", "aberrated"}, {"lateral_color", {0.1, -0.1}}};
  document["sensor"] = {{"width_px", 64}, {"height_px", 64}, {"pixel_pitch_um", 14}};
  document["burst"]["frames"] = 1;
  document["camera"]["focus_distance_m"] = 1;
  document["truth"] = {{"photograph_lens", "own"}, {"photograph_aperture_scale", 1}};
  document["render"] = {{"samples_per_pixel", 256}};
  const Simulation s = read_simulation(document, "s.json");
  const auto edge_m = static_cast<float>(15 * 14e-6 / s.lens.thin.image_distance_m());
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {5 + edge_m, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Image photograph = simulate(s, scene).truth->photograph;
  const double expected[3] = {32 + 16.5, 32 + 15, 32 + 13.5};
  for (int c = 0; c < 3; ++c) {
    double edge = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) edge += photograph.at(x, y, c) / photograph.at(3, 32, c) / 64;
    }
    EXPECT_NEAR(edge, expected[c], 0.016) << c;
  }
}

/// The height h in parts of the image radius at which a rim as wide as the pupil, which moves by `shift` pupil radii
/// over h = 1, leaves a share of the pupil free: two discs of radius 1 whose middles are d apart overlap by
/// 2 acos(d/2) - d/2 sqrt(4 - d^2).
double height_of_free_share(double share, double shift) {
  double low = 0, high = 2;
  for (int i = 0; i < 60; ++i) {
    const double d = 0.5 * (low + high);
    (2 * std::acos(0.5 * d) - 0.5 * d * std::sqrt(4 - d * d) > share * M_PI ? low : high) = d;
  }
  return low / shift;
}

TEST(SlowSimulate, SaysHowMuchOfThePhotographALensLights) {
  json document = minimal();
  document["sensor"] = {{"width_px", 256}, {"height_px", 256}, {"pixel_pitch_um", 14}};
  document["burst"]["frames"] = 1;
  document["camera"]["focus_distance_m"] = "inf";
  document["render"] = {{"samples_per_pixel", 1}};
  const TemporaryFolder folder;
  // in focus at infinity as far behind the pupil as the capture's: a sensor of the same size
  write_bytes(folder / "dark.json", R"({"version": 1, "name": "dark", "model": "aberrated", "f_number": 1.8,
    "image_radius_mm": 2, "falloff": "none", "rims": [{"radius": 1, "shift": 3}]})");
  document["truth"] = {{"photograph_lens", "dark.json"}};
  const Simulation s = read_simulation(document, folder / "s.json");
  const double radius_mm = 2 * height_of_free_share(0.01, 3), side_mm = 256 * 0.014;
  const double lit = M_PI * radius_mm * radius_mm / (side_mm * side_mm);
  // 256 rays find a hundredth of the pupil or a neighboring two; 64 x 64 places know the disc's edge to half a place
  const double near_mm = 2 * height_of_free_share(2.5 / 256, 3), far_mm = 2 * height_of_free_share(3.5 / 256, 3);
  const double tolerance =
      2 * M_PI * radius_mm * (0.5 * side_mm / 64 + std::abs(far_mm - near_mm)) / (side_mm * side_mm);
  const double found = lit_share(*prepare_photograph_lens(s));
  EXPECT_NEAR(found, lit, tolerance);
  const std::string lights = "lights " + std::to_string(static_cast<int>(100 * found)) + " % of the view";
  ASSERT_EQ(warnings_of(s).size(), 1u);
  EXPECT_EQ(warnings_of(s)[0],
            (folder / "s.json") + ": /truth/photograph_lens: dark " + lights + "; the rest of the photograph is black");
  EXPECT_EQ(simulate(s, step_under_a_sky()).truth->photograph_lens, "dark at f/1.8, " + lights);

  document["truth"] = {{"photograph_lens", "own"}, {"photograph_aperture_scale", 3}};
  const Simulation own = read_simulation(document, folder / "s.json");
  EXPECT_TRUE(warnings_of(own).empty());
  EXPECT_EQ(simulate(own, step_under_a_sky()).truth->photograph_lens, "thin lens at f/0.6");
  document["truth"]["photograph_aperture_scale"] = 5;
  const std::vector<std::string> wide = warnings_of(read_simulation(document, "s.json"));
  ASSERT_EQ(wide.size(), 1u);
  EXPECT_EQ(wide[0], "s.json: /truth/photograph_lens: own opens to f/0.36: no lens is wider than f/0.5");
}

/// A mesh of one triangle that is flat at `times_s` where `widths` is 0, and another that stays.
std::string flattened_triangle(const std::vector<float>& times_s, const std::vector<float>& widths) {
  GltfBuilder gltf = one_triangle();
  gltf.root["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, -1}}});
  gltf.root["scenes"][0]["nodes"] = {0, 1};
  gltf.root["materials"] = {{{"emissiveFactor", {1, 1, 1}}}};
  gltf.primitive()["material"] = 0;
  std::vector<float> factors;
  for (const float width : widths) factors.insert(factors.end(), {width, 1, 1});
  const int times = gltf.add_accessor<float>(times_s, "SCALAR");
  const int scales = gltf.add_accessor<float>(factors, "VEC3");
  const json sampler = {{"input", times}, {"output", scales}};
  const json channel = {{"sampler", 0}, {"target", {{"node", 1}, {"path", "scale"}}}};
  gltf.root["animations"] = json::array({{{"samplers", {sampler}}, {"channels", {channel}}}});
  return gltf.glb();
}

/// How an animated burst is refused; empty where it is not.
std::string animation_refusal(const json& document, const std::string& path) {
  const Simulation s = read_simulation(document, path);
  bool rendered = false;
  std::string message = dualpixel::simulator::refusal(
      [&] { simulate(s, load_scene(s), [&](const std::string&, double) { rendered = true; }); });
  EXPECT_FALSE(rendered);
  return message;
}

// A mesh that shrinks to nothing at 0.2 s, after the fifth frame as float has it: refused by its file's name and before
// the first frame is rendered.
TEST(Simulate, RefusesAnAnimationThatLosesTrianglesBeforeRendering) {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.glb", flattened_triangle({0, 0.2f}, {1, 0}));
  json document = minimal();
  document["sensor"] = {{"width_px", 8}, {"height_px", 8}};
  document["camera"] = {{"position_m", {0, 0, 1}}, {"look_at_m", {0, 0, 0}}};
  document["burst"] = {{"frames", 6}, {"animation", true}, {"interval_s", 0.05}};
  const char* const rest = " s triangles of mesh 1 appear or vanish: must be the same in all frames";
  EXPECT_EQ(animation_refusal(document, folder / "s.json"),
            (folder / "scene.glb") + ": /animations: at t = 0.25" + rest);

  // An even number of poses has none in the middle of the exposure, whose geometry truth shows. With 64 rows of 0.5 ms
  // the last of four bands is at 12 ms there, and at 7 and 17 ms in the two poses of 20 ms.
  write_bytes(folder / "scene.glb", flattened_triangle({0, 0.011f, 0.0115f, 0.0125f, 0.013f}, {1, 1, 0, 0, 1}));
  document["sensor"] = {{"width_px", 8}, {"height_px", 64}, {"row_time_us", 500}};
  document["exposure"] = {{"time_s", 0.02}};
  document["burst"] = {{"frames", 2}, {"animation", true}, {"interval_s", 0.1}, {"exposure_poses", 2}};
  EXPECT_EQ(animation_refusal(document, folder / "s.json"),
            (folder / "scene.glb") + ": /animations: at t = 0.012" + rest);
}

// What rendering is held against is the variance of a half in the views: of the electrons that a white thing frees
// under its filter, and of the read-outs that the views' profile states, 2.5 where right is sum - left, quantization
// aside.
TEST(SensorNoise, IsThatOfWhiteInTheViews) {
  json document = minimal();
  document["sensor"] = {{"width_px", 4},
                        {"height_px", 4},
                        {"dp_downsample_x", 1},
                        {"dp_downsample_y", 1},
                        {"readout", "sum_and_left"},
                        {"row_noise_dn", 2},
                        {"color_matrix", {0.7, 0.25, 0.05, 0.2, 0.7, 0.1, 0.02, 0.28, 0.7}},
                        {"illuminant", {1.3, 1, 0.6}}};
  const Simulation s = read_simulation(document, "s.json");
  constexpr double kLux = 0.2, kNits = 300;
  const ErrorTarget noise = sensor_noise(s, kLux);
  Image white(4, 4, 3);
  for (int i = 0; i < 16; ++i) {
    for (int c = 0; c < 3; ++c) white.data[3 * i + c] = static_cast<float>(kNits * s.sensor.illuminant[c]);
  }
  const Image electrons = expected_electrons(white, white, s.sensor, s.exposure, kLux);
  const double gain = gain_dn_per_electron(s.sensor, s.exposure.iso);
  const double read_e2 = (describe_exposure(s.sensor, s.exposure).dp_noise.read_dn2 - 2.5 / 12) / (gain * gain);
  const std::pair<int, int> photosites[3] = {{0, 0}, {1, 0}, {1, 1}};
  for (int c = 0; c < 3; ++c) {
    const double count = electrons.at(photosites[c].first, photosites[c].second, 0);
    const double nits = kNits * s.sensor.illuminant[c];
    const double expected = (count + read_e2) * (nits / count) * (nits / count);
    EXPECT_NEAR(noise.per_nit[c] * nits + noise.constant[c], expected, 1e-5 * expected) << c;
  }
}

TEST(Simulate, RefusesScenesBeyondMemory) {
  Simulation s = read_simulation(minimal(), "s.json");
  EXPECT_NO_THROW(check_memory(s, 0));
  EXPECT_THROW(check_memory(s, 1e15), InputError);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
