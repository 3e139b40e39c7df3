// The exposure that the meter sets, against the formula that its header states.
#include "scenes/drawn/meter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/drawn/face_box.h"
#include "scenes/shapes/solids.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

constexpr float kWall = 0.1f, kPerson = 0.6f;
constexpr double kWhite_nits = 1000;

/// Seconds at ISO 100 that the meter takes of an unlit wall and an unlit box of 2 `half_m` in front of its middle.
double metered_s(float half_m, bool is_person) {
  const TemporaryFolder folder;
  SceneBuilder build;
  build.scene["sensor"] = {{"width_px", 256}, {"height_px", 192}, {"pixel_pitch_um", 14.7}};
  build.scene["render"] = {{"max_bounces", 0}};
  build.scene["unlit_white_nits"] = kWhite_nits;
  build.camera({0, 0, 0}, {0, 0, -1});
  build.shooting.clear_m = 0.5f;
  Mesh wall, box;
  add_solid_box(wall, {0, 0, -3}, {4, 4, 0.1f});
  add_solid_box(box, {0, 0, -2}, {half_m, half_m, 0.1f});
  build.glb.add_node("wall", wall, build.glb.add_material(-1, vec3(kWall), true));
  build.glb.add_node("box", box, build.glb.add_material(-1, vec3(kPerson), true), is_person);
  build.glb.write(folder / "scene.glb");
  EXPECT_EQ(meter(build.scene, folder / "scene.json", build.shooting, 1, 0), std::vector<std::string>());
  const nlohmann::json& exposure = build.scene["exposure"];
  return exposure["time_s"].get<double>() * exposure["iso"].get<double>() / 100;
}

/// The same where so much of the weight is the box's: the weighted geometric mean becomes the key. Signal of a nit
/// second at f/1.8: E = pi L / (4 N^2), 4000 electrons per lux second in a well of 6000.
double expected_s(double box_share) {
  const double log_mean = (1 - box_share) * std::log(kWall) + box_share * std::log(kPerson);
  const double signal_per_nit_s = 3.14159265 / (4 * 1.8 * 1.8) * 4000 / 6000;
  return Shooting().key / (std::exp(log_mean) * kWhite_nits * signal_per_nit_s);
}

// Exposures have two digits, so each may be 5 % off; pixels that both share are a tenth of the smallest box, and off by
// less than half of the contrast, ln 6, of which people are half: at most 5 % again.
constexpr double kTolerance = 0.1;

TEST(Meter, PeopleCountAsMuchAsAllTheRest) {
  for (const float half_m : {0.15f, 0.3f, 0.45f}) {  // 4 % to 39 % of the picture
    EXPECT_NEAR(std::log(metered_s(half_m, true) / expected_s(0.5)), 0, kTolerance) << half_m;
  }
}

TEST(Meter, ThingsCountByTheirArea) {
  const double half_picture_m = 1.9 * 256 * 14.7e-3 / 2 / 4.3;  // at the box's front, of a lens of 4.3 mm
  const double share = 0.3 * 0.3 / (half_picture_m * half_picture_m * 0.75);
  EXPECT_NEAR(std::log(metered_s(0.3f, false) / expected_s(share)), 0, kTolerance) << share;
  EXPECT_GT(std::log(expected_s(share) / expected_s(0.5)), 3 * kTolerance);  // or these tests could not tell
}

// Digits are rounded within the limits that docs/scenes.md states.
TEST(Meter, TakesNoMoreThanTheCamerasIso) {
  nlohmann::json scene;
  const auto missed = set_exposure(scene, 1e6, 2);
  EXPECT_EQ(scene["exposure"]["iso"], 12800);
  ASSERT_TRUE(missed);
  EXPECT_LE(missed->taken_s, missed->limit_s * (1 + 1e-9));
}

// A face 3 m before a camera, .2 m wide, through lenses of two image distances and on two sensors.
TEST(FaceBox, IsThePinholesOfTheLens) {
  const std::vector<vec3> outline = {{-0.1f, 0.1f, -3}, {0.1f, 0.1f, -3}, {0, -0.1f, -3}, {0, 0.15f, -3}};
  simulator::Simulation s;
  s.sensor.width_px = 800, s.sensor.height_px = 600, s.sensor.pixel_pitch_um = 5;
  for (const double focal_m : {4.3e-3, 5e-3}) {
    s.lens.thin = {focal_m, 1.8, 1.0};
    const double scale = s.lens.thin.image_distance_m() / 5e-6 / 3;  // photosites a meter there
    const nlohmann::json box = face_box(outline, vec3(0), {0, 0, -1}, s);
    EXPECT_NEAR(box[0], 400 - 0.1 * scale, 1);
    EXPECT_NEAR(box[1], 300 - 0.15 * scale, 1);
    EXPECT_NEAR(box[2], 0.2 * scale, 1);
    EXPECT_NEAR(box[3], 0.25 * scale, 1);
  }
  s.sensor.width_px = s.sensor.height_px = 40;
  const nlohmann::json none = face_box(outline, vec3(0), {0, 0, -1}, s);
  EXPECT_TRUE(none.is_null()) << none;
}

TEST(FaceBox, FollowsLensFocusAndSensorButNoOtherPlace) {
  const std::vector<vec3> outline = {{-0.1f, 0.1f, -3}, {0.3f, 0.1f, -3}, {0, -0.1f, -3}, {0, 0.15f, -3}};
  simulator::Simulation before, after;
  before.sensor.width_px = 800, before.sensor.height_px = 600, before.sensor.pixel_pitch_um = 5;
  before.lens.thin = {4.3e-3, 1.8, 1.0};
  before.face_px = face_box(outline, vec3(0), {0, 0, -1}, before).get<std::array<double, 4>>();
  after.sensor.width_px = 320, after.sensor.height_px = 400, after.sensor.pixel_pitch_um = 7;
  after.lens.thin = {3e-3, 1.8, 0.5};
  const nlohmann::json expected = face_box(outline, vec3(0), {0, 0, -1}, after);
  const nlohmann::json box = face_box_after(before, after);
  ASSERT_EQ(box.size(), 4U);
  // a photosite for each rounding outwards, .5 of one before
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(box[i].get<double>(), expected[i].get<double>(), 2) << i;
  after.model_size_m = 2;
  EXPECT_TRUE(face_box_after(before, after).is_null());
  after.model_size_m.reset();
  after.pose.emplace();
  EXPECT_TRUE(face_box_after(before, after).is_null());
  after.pose.reset();
  after.sensor.width_px = after.sensor.height_px = 40;  // the box is not whole in it
  EXPECT_TRUE(face_box_after(before, after).is_null());
}

}  // namespace
}  // namespace dualpixel::scenes
