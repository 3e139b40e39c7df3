#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "scenes/people/held/held_things.h"
#include "simulator/render/intersector.h"

namespace dualpixel::scenes {
namespace {

/// Of a closed surface.
bool is_inside(const SceneObject& object, vec3 p) {
  simulator::Scene scene;
  scene.materials.emplace_back();
  simulator::Mesh& mesh = scene.meshes.emplace_back();
  mesh.positions = object.positions;
  mesh.triangles = object.triangles;
  const simulator::Intersector intersector(scene);
  int crossed = 0;
  const vec3 d = glm::normalize(vec3(0.3f, 0.9f, 0.2f));
  for (vec3 from = p; crossed < 50; ++crossed) {
    const auto hit = intersector.intersect({from, d});
    if (!hit) break;
    from += (static_cast<float>(hit->t) + 1e-4f) * d;
  }
  return crossed % 2 == 1;
}

TEST(HeldThings, HeldOutPeopleHoldThingsThatTrainingNeverHolds) {
  std::set<Held> training, held_out;
  RandomStream rng(3, false);
  for (int gesture = 0; gesture < kGestures; ++gesture) {
    for (int i = 0; i < 100; ++i) {
      const Held held = make_pose(rng, Body{}, static_cast<Gesture>(gesture)).held;
      if (held == Held::nothing || held == Held::bag) continue;  // bags hang on anybody's shoulder
      (gesture < kGestures - kReservedGestures ? training : held_out).insert(held);
    }
  }
  EXPECT_GE(training.size(), 9u);
  EXPECT_GE(held_out.size(), 2u);
  for (const Held held : held_out) EXPECT_EQ(training.count(held), 0u) << static_cast<int>(held);
}

TEST(HeldThings, ThingsAreInTheHandsThatHoldThemAndTheirPartsTouch) {
  int in_one = 0, parts = 0;
  for (int seed = 0; seed < 80; ++seed) {
    FigureOptions options;
    options.gesture = seed % 2 == 0 ? Gesture::with_thing : Gesture::anywhere;
    Figure figure = pose_figure(RandomStream(seed, false), options);
    SceneModel scene;
    add_held_thing(scene, figure, RandomStream(seed, false));
    if (figure.pose.held != Held::thing) continue;
    const Frame& hand = figure.skeleton.hand[figure.pose.held_side];
    if (figure.pose.both_hands) {
      const vec3 right = figure.skeleton.hand[1].origin, left = figure.skeleton.hand[0].origin;
      const float apart_m = glm::distance(left, right);
      float nearest = apart_m, farthest = 0;
      for (const vec3& p : scene.objects[0].positions) {
        const float along = glm::dot(p - left, right - left) / apart_m;
        nearest = std::min(nearest, along), farthest = std::max(farthest, along);
      }
      constexpr float kPalm_m = 0.0425f + 0.01f;  // how far the grip is from the hand's middle; what a thing is longer
      EXPECT_NEAR(nearest, 0, kPalm_m) << seed;
      EXPECT_NEAR(farthest, apart_m, kPalm_m) << seed;
    } else {
      ++in_one;
      EXPECT_TRUE(is_inside(scene.objects[0], hand.to_world({0, 0.02f, 0.035f}))) << seed;
    }
    for (std::size_t i = 1; i < scene.objects.size(); ++i, ++parts) {
      vec3 low(1e9f), high(-1e9f);
      for (const vec3& p : scene.objects[i].positions) low = glm::min(low, p), high = glm::max(high, p);
      EXPECT_TRUE(is_inside(scene.objects[i - 1], 0.5f * (low + high))) << seed << " " << i;
    }
  }
  EXPECT_GE(in_one, 8);
  EXPECT_GE(parts, 30);
}

}  // namespace
}  // namespace dualpixel::scenes
