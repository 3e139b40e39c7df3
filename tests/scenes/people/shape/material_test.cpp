#include <gtest/gtest.h>

#include "scenes/people/shape/reflectance.h"

namespace dualpixel::scenes {
namespace {

TEST(Materials, HaveReflectancesAtAllPositions) {
  RandomStream rng(11, false);
  for (const MaterialPool& pool : {cloth_pool(), wall_pool()}) {
    for (int i = 0; i < pool.count; ++i) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        Material material = wall_material(rng);
        material.kind = pool.kinds[i];
        material.scale_m = rng.uniform(0.01f, 0.6f);
        for (const float reach_m : {0.0f, 0.3f, 60.0f}) {
          const glm::vec3 color = reflectance(material, reach_m * rng.uniform3(-1, 1));
          for (int c = 0; c < 3; ++c) EXPECT_TRUE(color[c] >= 0 && color[c] < 2) << i << " " << color[c];
        }
      }
    }
  }
}

}  // namespace
}  // namespace dualpixel::scenes
