#include <gtest/gtest.h>

#include "scenes/people/body/skeleton.h"

namespace dualpixel::scenes {
namespace {

TEST(Skeletons, HandsFollowTheirForearms) {
  RandomStream rng(4, false);
  int bent_back = 0;
  constexpr int kHands = 400;
  for (int i = 0; i < kHands / 2; ++i) {
    const Body body = make_body(rng);
    const Skeleton k = make_skeleton(body, make_pose(rng, body, Gesture::anywhere), vec3(0), 0, proportions_of(body));
    for (int side = 0; side < 2; ++side) {
      const vec3 fore_arm = glm::normalize(k.wrist[side] - k.elbow[side]);
      bent_back += glm::dot(fore_arm, k.hand[side].axes[1]) < -0.1f ? 1 : 0;
    }
  }
  EXPECT_LT(bent_back, kHands / 50);
}

TEST(Skeletons, JointsKeepHumanLengths) {
  // Drillis & Contini 1966: upper arm .186 and forearm .146 (.332 in all), thigh .245, shank .246 of stature; every
  // pose moves hands and feet within reach, so no bone is stretched.
  RandomStream rng(9, false);
  for (int i = 0; i < 60; ++i) {
    const Body body = make_body(rng);
    const Pose pose = make_pose(rng, body, static_cast<Gesture>(i % kGestures));
    const Skeleton k = make_skeleton(body, pose, vec3(0), 0.3f, proportions_of(body));
    const float h = body.stature_m;
    constexpr float kRounding = 1e-4f;
    for (int side = 0; side < 2; ++side) {
      const float arm = glm::distance(k.shoulder[side], k.elbow[side]) + glm::distance(k.elbow[side], k.wrist[side]);
      EXPECT_NEAR(arm / h, 0.332f * (body.child ? 0.96f : 1.0f), kRounding);
      EXPECT_NEAR(glm::distance(k.hip[side], k.knee[side]) / h, 0.245f, kRounding);
      EXPECT_NEAR(glm::distance(k.knee[side], k.ankle[side]) / h, 0.246f, kRounding);
    }
    if (body.child) continue;  // their heads are larger, their necks not shorter than a neck
    const Skeleton upright = make_skeleton(body, Pose{}, vec3(0), 0, proportions_of(body));
    // the neck, .1 of stature at the most, leans by .12 radians: .1 (1 - cos .12) + .004 sin .12 = .0012
    EXPECT_NEAR((upright.head.origin.y + 0.137f * body.head_scale) / h, 1, 0.0013f);
  }
}

}  // namespace
}  // namespace dualpixel::scenes
