#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/people/photo/camera.h"
#include "scenes/procedural/random_stream.h"

namespace dualpixel::scenes {
namespace {

TEST(Cameras, NothingVisibleIsBelowTheLowestVisibleHeight) {
  RandomStream rng(4, false);
  for (int i = 0; i < 20; ++i) {
    CameraSetup plan;
    plan.eye = {rng.uniform(-0.5f, 0.5f), rng.uniform(0.5f, 2), rng.uniform(0.8f, 3)};
    plan.target = {0, rng.uniform(0.8f, 1.6f), 0};
    plan.height_m = rng.uniform(0.5f, 2);
    plan.roll = rng.uniform(-0.1f, 0.1f);
    const auto camera = make_camera(plan);
    const float lowest = lowest_visible_m(camera, 0.6f);
    float seen = 9;
    for (int k = 0; k < 20000; ++k) {
      const vec3 p(rng.uniform(-2, 2), rng.uniform(-2, 3), rng.uniform(-0.6f, 0.6f));
      const vec3 at = project(camera, p);
      if (at.z > 0.05f && at.x > 0 && at.y > 0 && at.x < 192 && at.y < 256) seen = std::min(seen, p.y);
      const vec3 back = vec3(camera.world_from_camera[3]) + glm::distance(p, plan.eye) * direction_of(camera, vec2(at));
      if (at.z > 0.05f) {
        EXPECT_LT(glm::distance(back, p), 1e-3f);  // at most 6 m away, in floats
      }
    }
    EXPECT_GE(seen, lowest - 1e-4f);
  }
}

}  // namespace
}  // namespace dualpixel::scenes
