#include <gtest/gtest.h>

#include <array>
#include <utility>

#include "scenes/people/shape/primitives.h"
#include "scenes/people/truth.h"
#include "tests/scenes/people/figures.h"

namespace dualpixel::scenes {
namespace {

enum Coco { kLeftElbow = 7, kRightElbow, kLeftWrist, kRightWrist, kLeftHip, kRightHip, kLeftAnkle = 15, kRightAnkle };

TEST(PeopleTruth, FaceBoxHoldsEyesAndNoseAndLiesOnTheHead) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Pair pair = Pair::make(seed);
    for (const Figure* figure : {&pair.first, &pair.second}) {
      const glm::vec4 box = face_box(*figure, pair.camera);
      const auto joints = keypoints_of(*figure);
      for (int i = 0; i < 3; ++i) {
        const vec3 at = project(pair.camera, joints[i]);
        EXPECT_TRUE(at.x > box.x && at.x < box.x + box.z && at.y > box.y && at.y < box.y + box.w) << seed << ' ' << i;
      }
      // the skull is 24 cm high, 20 cm long (with the nose) and 18 cm wide (with ears) at scale 1: see HeadShape
      vec2 low(1e9f), high(-1e9f);
      for (int corner = 0; corner < 8; ++corner) {
        const vec3 local((corner & 1) != 0 ? 0.09f : -0.09f, (corner & 2) != 0 ? 0.135f : -0.11f,
                         (corner & 4) != 0 ? 0.1f : -0.11f);
        const vec2 at(project(pair.camera, figure->skeleton.head.to_world(figure->body.head_scale * local)));
        low = glm::min(low, at);
        high = glm::max(high, at);
      }
      EXPECT_GE(box.x, low.x);
      EXPECT_GE(box.y, low.y);
      EXPECT_LE(box.x + box.z, high.x);
      EXPECT_LE(box.y + box.w, high.y);
    }
  }
}

TEST(PeopleTruth, KeypointsOfAKnownPoseAreAtTheirComputedPositions) {
  const PeopleSample truth = Upright(Pose{}).truth();
  // hips at (+-0.085, 0.525 * 1.7, 0) m, ankles at (+-0.06 * 1.7, 0.045 * 1.7, 0): see make_skeleton(). The left is
  // at the right of the picture.
  const auto at = [](float x_m, float y_m) { return vec2(96 + 128 * x_m, 128 + 128 * (1 - y_m)); };
  const std::array<std::pair<int, vec2>, 4> expected = {{{kLeftHip, at(0.085f, 0.8925f)},
                                                         {kRightHip, at(-0.085f, 0.8925f)},
                                                         {kLeftAnkle, at(0.102f, 0.0765f)},
                                                         {kRightAnkle, at(-0.102f, 0.0765f)}}};
  for (const auto& [i, position] : expected) {
    EXPECT_NEAR(truth.keypoints[i].x, position.x, 0.01f) << i;  // float sums of terms up to 256
    EXPECT_NEAR(truth.keypoints[i].y, position.y, 0.01f) << i;
  }
  for (int left = 1; left < kKeypoints; left += 2) {
    EXPECT_GT(truth.keypoints[left].x, truth.keypoints[left + 1].x) << left;
  }
  for (const int i : {0, 1, 2, +kLeftElbow, +kRightElbow, +kLeftHip, +kRightHip})
    EXPECT_EQ(truth.keypoints[i].z, 2) << i;
}

TEST(PeopleTruth, AHandBehindTheBackIsHidden) {
  Pose pose;
  pose.arm[1].wrist = {0.02f, -0.05f, -0.13f};
  pose.arm[1].elbow = {1, -0.2f, -0.6f};
  const PeopleSample truth = Upright(pose).truth();
  EXPECT_EQ(truth.keypoints[kRightWrist].z, 1);
  EXPECT_EQ(truth.keypoints[kLeftWrist].z, 2);
}

TEST(PeopleTruth, AnObjectInFrontOfAnElbowHidesIt) {
  // 12 cm before an elbow of 4 cm radius
  Upright upright{Pose{}};
  EXPECT_EQ(upright.truth().keypoints[kLeftElbow].z, 2);
  SceneObject board;
  add_box(board, upright.figure.skeleton.elbow[0] + vec3(0, 0, 0.12f), mat3(1), {0.06f, 0.06f, 0.002f});
  add_object(upright.scene, upright.figure, board, Material{});
  EXPECT_EQ(upright.truth().keypoints[kLeftElbow].z, 1);
}

}  // namespace
}  // namespace dualpixel::scenes
