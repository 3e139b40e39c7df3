#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "scenes/people/environment/environment.h"
#include "scenes/people/photo/ray_tracer.h"
#include "tests/scenes/people/figures.h"

namespace dualpixel::scenes {
namespace {

TEST(Environments, DomainRandomizedPicturesAreMostlyGenericAndNeverHeldOut) {
  constexpr int kDraws = 400;
  // fractions of generic cloth, walls, gestures, environments
  const auto shares = [](RandomStream rng) {
    std::array<double, 4> share{};
    for (int i = 0; i < kDraws; ++i) {
      RandomStream part = rng.substream(static_cast<std::uint64_t>(i));
      SceneModel scene;
      const std::string tag = add_environment(scene, part.substream(1), 2);
      const Gesture gesture = random_gesture(part);
      share[0] += cloth_material(part).kind == Material::Kind::medley;
      share[1] += wall_material(part).kind == Material::Kind::medley;
      share[2] += gesture == Gesture::anywhere || gesture == Gesture::with_thing;
      share[3] += tag == "place:painted" || tag == "place:jumble" || tag == "place:rows" || tag == "place:mixed";
    }
    for (double& s : share) s /= kDraws;
    return share;
  };
  RandomStream randomized(3, false), randomized_held_out(3, true);
  randomized.set_domain_randomized(), randomized_held_out.set_domain_randomized();
  const auto usual = shares(RandomStream(3, false)), odd = shares(randomized), held_out = shares(randomized_held_out);
  for (int i = 0; i < 4; ++i) {
    EXPECT_GT(odd[i], 0.6 - 4 * std::sqrt(0.6 * 0.4 / kDraws)) << i;  // .6 of them, and some of the others
    EXPECT_LT(usual[i], 0.45) << i;
    EXPECT_EQ(held_out[i], 0) << i;
  }
  EXPECT_FALSE(randomized_held_out.domain_randomized());
}

TEST(SlowEnvironments, AreNotInFrontOfPeople) {
  for (int seed = 0; seed < 40; ++seed) {
    Upright upright({});
    RandomStream rng(seed, false);
    if (seed % 2 == 1) rng.set_domain_randomized();
    add_environment(upright.scene, rng, seed % 4 < 2 ? 1.5f : 0.8f);
    EXPECT_LT(visibility_of(RayTracer(upright.scene), upright.camera).occluded, 0.002)
        << seed;  // soles may lie in a floor
  }
}

TEST(Environments, WallsAreBehindRowsAndJumbles) {
  int walls = 0;
  for (int seed = 0; seed < 200; ++seed) {
    SceneModel scene;
    const std::string tag = add_environment(scene, RandomStream(seed, false), 2);
    if (tag != "place:rows" && tag != "place:jumble") continue;
    for (const SceneObject& wall : scene.objects) {
      const float width_m = glm::distance(wall.positions[0], wall.positions[1]);
      if (wall.positions.size() != 4 || std::abs(width_m - 40) > 0.1f) continue;
      ++walls;
      const vec3 normal = wall.normals[0] * (glm::dot(wall.normals[0], wall.positions[0]) < 0 ? 1.0f : -1.0f);
      for (const SceneObject& object : scene.objects) {
        if (&object == &wall || std::abs(object.normals[0].y) > 0.999f) continue;  // the ground
        for (const vec3& p : object.positions) {
          ASSERT_GT(glm::dot(p - wall.positions[0], normal), 0) << seed << " " << tag;
        }
      }
    }
  }
  EXPECT_GE(walls, 10);
}

TEST(Environments, ThingsInMixedOnesAreInFrontOfTheirWalls) {
  int walls = 0;
  for (int seed = 0; seed < 400; ++seed) {
    SceneModel scene;
    RandomStream rng(seed, false);
    rng.set_domain_randomized();
    if (add_environment(scene, rng, 0.6f) != "place:mixed") continue;
    const auto wall = std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& object) {
      const float width_m = glm::distance(object.positions[0], object.positions[1]);
      const bool studio = std::abs(width_m - 30) < 0.1f, painted = std::abs(width_m - 24) < 0.1f;
      return object.positions.size() == 4 && (studio || painted) && std::abs(object.normals[0].y) < 0.5f;
    });
    if (wall == scene.objects.end()) continue;
    ++walls;
    const vec3 at = wall->positions[0],
               inwards = wall->normals[0] * (glm::dot(wall->normals[0], at) < 0 ? 1.0f : -1.0f);
    for (const SceneObject& object : scene.objects) {
      if (&object == &*wall) continue;
      float nearest_m = -1;
      for (const vec3& p : object.positions) nearest_m = std::max(nearest_m, glm::dot(p - at, inwards));
      EXPECT_GT(nearest_m, 0.05f) << seed;
    }
  }
  EXPECT_GE(walls, 10);
}

}  // namespace
}  // namespace dualpixel::scenes
