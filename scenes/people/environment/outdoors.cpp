#include "scenes/people/environment/environments.h"

#include <algorithm>
#include <cmath>

#include "scenes/people/environment/plants.h"

namespace dualpixel::scenes {

void add_garden(EnvironmentBuilder& build, RandomStream& rng, float back) {
  Material grass;
  grass.kind = rng.chance(0.7f) ? Material::Kind::grass : Material::Kind::paving;
  grass.a = vec3(rng.uniform(0.06f, 0.2f), rng.uniform(0.14f, 0.3f), rng.uniform(0.02f, 0.08f));
  if (grass.kind == Material::Kind::paving) grass.a = vec3(rng.uniform(0.2f, 0.5f)), grass.b = 0.4f * grass.a;
  grass.c = grass.a * rng.uniform(0.5f, 1.8f);
  grass.scale_m = 0.4f;
  grass.seed = rng.seed();
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -50}, grass);
  const int layers = 1 + rng.below(3);
  for (int i = 0; i < layers; ++i) {
    const float z = -back - 2.5f * static_cast<float>(i) - rng.uniform(0, 1);
    const float high = rng.uniform(0.8f, 3.5f);
    if (rng.chance(0.5f)) {
      build.quad({-20, 0, z}, {40, 0, 0}, {0, high, 0}, leaves_material(rng));
    }
    SceneObject& hedge = build.object(leaves_material(rng));
    for (int k = 0; k < 6; ++k) {
      add_leaves(hedge, rng,
                 {rng.uniform(-3, 3) - z * 0.2f * rng.uniform(-1, 1), high * rng.uniform(0.2f, 0.9f),
                  z + rng.uniform(0, 0.5f)},
                 {rng.uniform(0.4f, 1), rng.uniform(0.4f, 0.9f), 0.4f}, 150, rng.uniform(0.08f, 0.3f));
    }
  }
  const int trees = rng.below(4);
  for (int i = 0; i < trees; ++i)
    add_tree(build, rng, {rng.uniform(-5, 5), 0, -back - rng.uniform(0.5f, 8)}, rng.uniform(2, 6));
}

void add_street(EnvironmentBuilder& build, RandomStream& rng, float back) {
  Material ground = wall_material(rng);
  ground.kind = Material::Kind::paving;
  ground.a = vec3(rng.uniform(0.1f, 0.5f)), ground.b = 0.5f * ground.a, ground.c = 0.8f * ground.a;
  ground.scale_m = rng.uniform(0.3f, 1);
  build.quad({-40, 0, 10}, {80, 0, 0}, {0, 0, -80}, ground);
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < 4; ++i) {
      Material house = wall_material(rng);
      if (rng.chance(0.75f)) house.kind = Material::Kind::facade, house.scale_m = rng.uniform(1.4f, 3);
      const float depth = rng.uniform(2, 4), tall = rng.uniform(2.5f, 8);
      build.box({side * (rng.uniform(2.5f, 6) + 2), tall, -back - 8 * static_cast<float>(i)}, {2, tall, depth}, house);
    }
  }
  if (rng.chance(0.6f)) {
    Material house = wall_material(rng);
    house.kind = rng.chance(0.7f) ? Material::Kind::facade : Material::Kind::crowd;
    house.scale_m = house.kind == Material::Kind::facade ? rng.uniform(1.4f, 3) : 0.5f;
    const float tall = house.kind == Material::Kind::facade ? rng.uniform(3, 9) : 2.1f;
    build.box({0, tall, -back - rng.uniform(4, 25)}, {15, tall, 1}, house);
  }
  const int cars = rng.below(4);
  for (int i = 0; i < cars; ++i) {
    const Material paint = plain_material(random_color(rng), 0.5f);
    const float x = rng.uniform(-4, 4), z = -back - rng.uniform(1, 12), yaw = rng.chance(0.5f) ? 0.0f : 1.5f;
    build.box({x, 0.65f, z}, {2.1f, 0.38f, 0.85f}, paint, yaw);
    build.box({x, 1.2f, z}, {1.1f, 0.26f, 0.75f}, plain_material(vec3(0.03f), 0.7f), yaw);
  }
  const int posts = rng.below(4);
  for (int i = 0; i < posts; ++i) {
    const float x = rng.uniform(-3, 3), z = -back - rng.uniform(0, 8);
    add_tube(build.object(plain_material(vec3(rng.uniform(0.02f, 0.3f)))), {{x, 0, z}, {x, 5, z}}, {0.06f, 0.05f}, 8);
    if (rng.chance(0.4f)) build.box({x, rng.uniform(1.8f, 2.6f), z}, {0.35f, 0.35f, 0.02f}, wall_material(rng));
  }
  if (rng.chance(0.4f)) add_tree(build, rng, {rng.uniform(-4, 4), 0, -back - rng.uniform(1, 6)}, rng.uniform(2, 6));
}

void add_landscape(EnvironmentBuilder& build, RandomStream& rng, float back) {
  Material ground = wall_material(rng);
  ground.kind = rng.chance(0.5f) ? Material::Kind::grass : Material::Kind::rough;
  ground.a = rng.chance(0.4f) ? vec3(0.5f, 0.42f, 0.3f) : vec3(0.15f, 0.25f, 0.08f) * rng.uniform(0.5f, 2);
  ground.c = ground.b = 0.6f * ground.a;
  build.quad({-200, 0, 10}, {400, 0, 0}, {0, 0, -400}, ground);
  if (rng.chance(0.5f))
    build.quad({-200, 0.01f, -back - 5}, {400, 0, 0}, {0, 0, -200}, plain_material(vec3(0.06f, 0.12f, 0.16f), 0.3f));
  const int hills = 2 + rng.below(3);
  for (int i = 0; i < hills; ++i) {
    SceneObject& hill = build.object(
        rng.chance(0.5f) ? leaves_material(rng) : plain_material(vec3(0.12f, 0.18f, 0.22f) * rng.uniform(0.5f, 2)));
    const float z = -30 - 20 * static_cast<float>(i), wide = rng.uniform(15, 40);
    add_ellipsoid(hill, {rng.uniform(-40, 40), -2, z}, {wide, rng.uniform(3, 14), 8}, mat3(1), 10);
  }
}

void add_lights_at_night(EnvironmentBuilder& build, RandomStream& rng, float back) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -40}, plain_material(vec3(0.05f), 0.1f));
  build.quad({-30, 0, -back - 14}, {60, 0, 0}, {0, 20, 0}, wall_material(rng));
  const int lights = 30 + rng.below(60);
  for (int i = 0; i < lights; ++i) {
    const float z = -back - rng.uniform(1, 12);
    const vec3 color = rng.chance(0.5f) ? vec3(1, 0.75f, 0.4f) : random_color(rng) + 0.1f;
    add_ellipsoid(build.object(emissive_material(color * rng.uniform(4, 40))),
                  {rng.uniform(-0.5f, 0.5f) * (3 - z), rng.uniform(0.2f, 3.2f), z}, vec3(rng.uniform(0.01f, 0.07f)),
                  mat3(1), 4);
  }
}

void add_market(EnvironmentBuilder& build, RandomStream& rng, float back) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -40}, wall_material(rng));
  build.quad({-20, 0, -back - 8}, {40, 0, 0}, {0, 9, 0}, wall_material(rng));
  for (int i = 0; i < 6; ++i) {
    const float x = rng.uniform(-4, 4), z = -back - rng.uniform(0, 5);
    Material awning = cloth_material(rng);
    awning.kind = Material::Kind::stripes_along;
    awning.scale_m = 0.3f;
    build.quad({x - 1, 2.1f, z}, {2, 0, 0}, {0, 0.5f, -1.2f}, awning);
    build.box({x, 0.45f, z - 0.4f}, {1, 0.45f, 0.4f}, wall_material(rng));
    SceneObject& goods = build.object(cloth_material(rng));
    for (int k = 0; k < 25; ++k)
      add_ellipsoid(goods, {x + rng.uniform(-0.9f, 0.9f), 0.95f, z - rng.uniform(0.1f, 0.7f)},
                    vec3(rng.uniform(0.04f, 0.1f)), mat3(1), 4);
  }
}

}  // namespace dualpixel::scenes
