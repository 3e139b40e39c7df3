// A shutter that rolls: each row sees the scene, and is seen by truth, at its own time.
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/sensor/hand_shake.h"
#include "simulator/simulate.h"
#include "tests/simulator/scene/gltf/gltf_builder.h"
#include "tests/simulator/test_scenes.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

using nlohmann::json;

constexpr int kWidth = 64, kHeight = 48;
constexpr double kRow_s = 200e-6, kInterval_s = 0.04, kShake = 50;

json document_of(int width, int height, double row_time_us) {
  return {
      {"version", 1},
      {"gltf", "scene.glb"},
      {"camera", {{"focus_distance_m", 1}}},
      {"sensor", {{"width_px", width}, {"height_px", height}, {"pixel_pitch_um", 14}, {"row_time_us", row_time_us}}},
      {"exposure", {{"time_s", 1e-4}}},
      {"burst", {{"frames", 2}, {"interval_s", kInterval_s}}},
      {"render", {{"samples_per_pixel", 16}}}};
}

// Against the path of the hand itself: the pixel's ray at its row's time meets the wall at 1 m, and the point is seen
// in the second frame in the row, found by bisection, at whose own time it lies in that row. The program takes the time
// of the row's middle: at 50 x 0.015 rad/s, 319 photosites of focal length, half a row is 0.024 px; twice that.
TEST(RollingShutter, TruthOfAShakenBurstIsRightRowByRow) {
  json document = document_of(kWidth, kHeight, 1e6 * kRow_s);
  document["burst"]["hand_shake"] = kShake;
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Simulation s = read_simulation(document, "s.json");
  const Capture capture = simulate(s, scene);
  const double focal_px = s.lens.thin.image_distance_m() / 14e-6;
  const auto pose_at = [&](double time_s) { return hand_shake(s.hand_shake_seed, time_s, kShake); };
  double skew = 0;
  for (int y = 1; y < kHeight; y += 5) {
    for (int x = 1; x < kWidth; x += 9) {
      const glm::dmat4 first = pose_at((y + 0.5 - kHeight / 2) * kRow_s);
      const glm::dvec3 ray =
          glm::dmat3(first) * glm::dvec3((x + 0.5 - kWidth / 2) / focal_px, (y + 0.5 - kHeight / 2) / focal_px, 1);
      const double depth_m = (1 - first[3].z) / ray.z;
      EXPECT_NEAR(capture.truth->depth_m.at(x, y), depth_m, 1e-5);
      const glm::dvec4 point(glm::dvec3(first[3]) + depth_m * ray, 1);
      const auto seen_at = [&](double row) {
        const glm::dvec3 p = glm::inverse(pose_at(kInterval_s + (row - kHeight / 2) * kRow_s)) * point;
        return glm::dvec2(kWidth / 2 + focal_px * p.x / p.z, kHeight / 2 + focal_px * p.y / p.z);
      };
      double low = -50, high = 100;
      for (int i = 0; i < 50; ++i) {
        const double row = 0.5 * (low + high);
        (seen_at(row).y > row ? low : high) = row;
      }
      const glm::dvec2 seen = seen_at(low);
      if (seen.y < 0 || seen.y >= kHeight) continue;  // beyond the picture the last row's time is taken
      EXPECT_NEAR(capture.truth->motion[0].at(x, y, 0), seen.x - (x + 0.5), 0.05) << x << ' ' << y;
      EXPECT_NEAR(capture.truth->motion[0].at(x, y, 1), seen.y - (y + 0.5), 0.05) << x << ' ' << y;
      skew = std::max(skew, glm::length(seen - seen_at(kHeight / 2)));
    }
  }
  EXPECT_GT(skew, 0.4);  // what a shutter for all rows together would be off by
  const glm::dmat4 middle = glm::inverse(pose_at(kInterval_s));
  EXPECT_NEAR(capture.frames[1].camera_from_world[3], middle[3].x, 1e-7);
}

/// Covers what lies right of a vertical edge, 1 m ahead of a camera at (0, 0, 1). The edge moves by 0.5 m/s along x
/// from -0.02 m at time 0.
std::string moving_edge() {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["attributes"]["POSITION"] = gltf.add_accessor<float>({0, -2, 0, 4, 0, 0, 0, 2, 0}, "VEC3");
  gltf.root["materials"] = {{{"emissiveFactor", {1, 1, 1}},
                             {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 20000}}}}}}};
  gltf.primitive()["material"] = 0;
  const int times = gltf.add_accessor<float>({0, 1}, "SCALAR");
  const int places = gltf.add_accessor<float>({-0.02f, 0, 0, 0.48f, 0, 0}, "VEC3");
  const json sampler = {{"input", times}, {"output", places}};
  const json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}};
  gltf.root["animations"] = json::array({{{"samplers", {sampler}}, {"channels", {channel}}}});
  return gltf.glb();
}

// A mean over four poses of the exposure, each row at its own time in each: the edge of a wall at 1 m lies where, on
// the average over the poses, the hand has it. 256 samples of a photosite know it to a sixteenth; the four are
// independent.
TEST(RollingShutter, RowsOfEachPoseAreExposedAtTheirOwnTime) {
  constexpr int kPoses = 4;
  constexpr double kExposure_s = 0.02;
  json document = document_of(kWidth, kHeight, 1000);
  document["exposure"]["time_s"] = kExposure_s;
  document["burst"] = {{"frames", 2}, {"interval_s", 0.05}, {"hand_shake", kShake}, {"exposure_poses", kPoses}};
  document["render"]["samples_per_pixel"] = kPoses * 256;
  Scene scene;
  scene.materials = {glowing(100)};
  scene.meshes = {make_quad({-5, -5, -1}, {5, 0, 0}, {0, 10, 0}, 0)};  // what lies left of x = 0
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Simulation s = read_simulation(document, "s.json");
  const Truth truth = *simulate(s, scene).truth;
  const double focal_px = s.lens.thin.image_distance_m() / 14e-6;
  double first_edge = 0, farthest = 0;
  for (int y = 0; y < kHeight; ++y) {
    double expected = 0, seen = 0;
    for (int i = 0; i < kPoses; ++i) {
      const double time_s = (y + 0.5 - kHeight / 2) * 1e-3 + ((i + 0.5) / kPoses - 0.5) * kExposure_s;
      const glm::dmat4 pose = hand_shake(s.hand_shake_seed, time_s, kShake);
      const auto world_x = [&](double x) {
        const glm::dvec3 ray =
            glm::dmat3(pose) * glm::dvec3((x - kWidth / 2) / focal_px, (y + 0.5 - kHeight / 2) / focal_px, 1);
        return pose[3].x + (1 - pose[3].z) / ray.z * ray.x;
      };
      const double at_0 = world_x(0), at_end = world_x(kWidth);  // linear but for the tilt's second order
      expected += kWidth * at_0 / (at_0 - at_end) / kPoses;
    }
    for (int x = 0; x < kWidth; ++x) {
      seen += (truth.left.at(x, y, 1) + truth.right.at(x, y, 1)) / (truth.left.at(3, y, 1) + truth.right.at(3, y, 1));
    }
    EXPECT_NEAR(seen, expected, 4.0 / 16 / std::sqrt(kPoses)) << y;
    if (y == 0) first_edge = expected;
    farthest = std::max(farthest, std::abs(expected - first_edge));
  }
  EXPECT_GT(farthest, 1);  // what a shutter for all rows together would be off by
}

// Bands of 16 rows, 8 ms apart, see the edge 0.5 m/s x 8 ms x 319 = 1.27 photosites farther each, on the average over
// the poses of an exposure, too. In the frame a band's sixteen rows tell where: some 1900 electrons are known to 2.3 %,
// so that a row's sixteen quotients add up to .28 px of error, most of it from the two photosites that they are over;
// four standard errors of sixteen rows. Motion is the distance between the two times of the pixel's own band; before
// time 0 the animation has not begun.
class AnimatedRollingShutter : public ::testing::TestWithParam<int> {};

TEST_P(AnimatedRollingShutter, ShearsThingsAndTruthWithThem) {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.glb", moving_edge());
  json document = document_of(32, 64, 500);
  document["camera"] = {{"position_m", {0, 0, 1}}, {"look_at_m", {0, 0, 0}}, {"focus_distance_m", 1}};
  document["burst"]["animation"] = true;
  document["burst"]["interval_s"] = 0.1;
  document["burst"]["exposure_poses"] = GetParam();
  const Simulation s = read_simulation(document, folder / "s.json");
  const Capture capture = simulate(s, load_scene(s));
  const double focal_px = s.lens.thin.image_distance_m() / 14e-6;
  const auto edge_px = [&](double time_s) { return 16 + focal_px * (-0.02 + 0.5 * std::max(time_s, 0.0)); };
  for (int y = 0; y < 64; ++y) {
    const double delay_s = (y / 16 * 16 + 8 - 32) * 500e-6;
    if (y % 16 == 0) {
      double covered = 0;  // photosites of a row, over what those at the right border see under the same filter
      for (int row = y; row < y + 16; ++row) {
        const auto signal = [&](int x) { return capture.frames[1].mosaic.at(x, row) - 64.0; };
        for (int x = 0; x < 32; ++x) covered += signal(x) / signal(30 + x % 2) / 16;
      }
      EXPECT_NEAR(32 - covered, edge_px(0.1 + delay_s), 4 * 0.28 / 4) << y;
    }
    int x = 0;
    while (x < 32 && capture.truth->valid.at(x, y) == 0) ++x;
    EXPECT_NEAR(x, edge_px(delay_s), 0.51) << y;  // the first pixel whose center is covered
    EXPECT_NEAR(capture.truth->motion[0].at(31, y, 0), edge_px(0.1 + delay_s) - edge_px(delay_s), 0.01) << y;
    EXPECT_NEAR(capture.truth->motion[0].at(31, y, 1), 0, 0.01) << y;
  }
}

INSTANTIATE_TEST_SUITE_P(Poses, AnimatedRollingShutter, ::testing::Values(1, 2));

TEST(RollingShutter, OfNoTimeIsNone) {
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {5, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  json document = document_of(16, 16, 0);
  document["burst"]["hand_shake"] = 1;
  const ImageU16 together = simulate(read_simulation(document, "s.json"), scene).frames[1].mosaic;
  // a shutter that rolls by next to nothing takes the other way through the program to the same picture
  document["sensor"]["row_time_us"] = 1e-6;
  const ImageU16 hardly = simulate(read_simulation(document, "s.json"), scene).frames[1].mosaic;
  for (std::size_t i = 0; i < together.data.size(); ++i) EXPECT_NEAR(hardly.data[i], together.data[i], 1) << i;
  document["sensor"]["row_time_us"] = 1000;
  document["burst"]["hand_shake"] = 50;
  const ImageU16 rolled = simulate(read_simulation(document, "s.json"), scene).frames[1].mosaic;
  document["sensor"]["row_time_us"] = 0;
  EXPECT_NE(rolled.data, simulate(read_simulation(document, "s.json"), scene).frames[1].mosaic.data);
  document["sensor"]["row_time_us"] = -1;
  EXPECT_THROW(read_simulation(document, "s.json"), InputError);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
