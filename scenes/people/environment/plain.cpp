#include "scenes/people/environment/environments.h"

namespace dualpixel::scenes {

void add_studio(EnvironmentBuilder& build, RandomStream& rng, float back) {
  Material material = plain_material(random_color(rng));
  if (rng.chance(0.4f)) {
    material.kind = Material::Kind::rough;
    material.scale_m = rng.uniform(0.3f, 1.5f);
    material.b = material.a * rng.uniform(0.5f, 0.9f);
    material.seed = rng.seed();
  }
  build.quad({-15, -1, -back}, {30, 0, 0}, {0, 12, 0}, material);
  build.quad({-15, 0, 6}, {30, 0, 0}, {0, 0, -6 - back}, material);
}

void add_wall(EnvironmentBuilder& build, RandomStream& rng, float back) {
  const float z = -0.35f - 0.4f * back * rng.uniform();
  build.quad({-15, 0, z}, {30, 0, 0}, {0, 8, 0}, wall_material(rng));
  build.quad({-15, 0, 6}, {30, 0, 0}, {0, 0, -12}, wall_material(rng));
  if (rng.chance(0.3f)) build.box({rng.uniform(-1.5f, 1.5f), 1.2f, z}, {0.5f, 1.2f, 0.04f}, wall_material(rng));
}

}  // namespace dualpixel::scenes
