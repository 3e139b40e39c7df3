#include "scenes/people/environment/environments.h"

#include <algorithm>
#include <iterator>

#include "scenes/people/environment/plants.h"

namespace dualpixel::scenes {
namespace {

void add_picture(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const float z = -back + 0.02f;
  const vec3 size(rng.uniform(0.15f, 0.6f), rng.uniform(0.15f, 0.5f), 0.015f);
  const float y = rng.uniform(1.2f, 1.9f);
  build.box({x, y, z}, size + vec3(0.03f, 0.03f, -0.004f), plain_material(random_color(rng)));
  Material picture = wall_material(rng);
  picture.kind = Material::Kind::collage;
  picture.scale_m = rng.uniform(0.1f, 0.5f);
  build.box({x, y, z}, size, picture);
}

void add_window(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const float z = -back + 0.02f;
  const vec3 size(rng.uniform(0.4f, 1.1f), rng.uniform(0.5f, 0.9f), 0.02f);
  const float y = rng.uniform(1.2f, 1.8f);
  build.box({x, y, z}, size + vec3(0.06f, 0.06f, -0.005f), plain_material(vec3(rng.uniform(0.3f, 0.9f))));
  Material outside = rng.chance(0.5f) ? leaves_material(rng) : wall_material(rng);
  outside.emission = vec3(rng.uniform(1, 6));
  build.box({x, y, z}, size,
            rng.chance(0.4f) ? emissive_material(vec3(rng.uniform(1.5f, 6)) * vec3(0.9f, 1, 1.1f)) : outside);
  for (const float bar : {-0.33f, 0.33f})
    build.box({x + bar * size.x, y, z + 0.02f}, {0.02f, size.y, 0.02f}, plain_material(vec3(0.7f)));
  if (rng.chance(0.5f)) {
    Material curtain = cloth_material(rng);
    curtain.kind = Material::Kind::stripes_along;
    curtain.scale_m = 0.08f;
    curtain.b = 0.7f * curtain.a;
    for (const float s : {-1.0f, 1.0f}) build.box({x + s * size.x, 1.3f, z + 0.06f}, {0.2f, 1.2f, 0.02f}, curtain);
  }
}

void add_bookshelf(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const float z = -back + 0.02f;
  Material material;
  material.kind = Material::Kind::books;
  material.scale_m = rng.uniform(0.03f, 0.06f);
  material.seed = rng.seed();
  material.a = vec3(0.36f, 0.22f, 0.12f) * rng.uniform(0.3f, 1.8f);
  material.b = 0.4f * material.a;
  const float high = rng.uniform(0.5f, 1.1f);
  build.box({x, high, z + 0.15f}, {rng.uniform(0.4f, 1.2f), high, 0.16f}, material);
}

void add_door(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const float z = -back + 0.02f;
  build.box({x, 1, z}, {0.45f, 1.02f, 0.02f}, plain_material(random_color(rng), 0.1f));
}

void add_sofa(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const Material cloth = cloth_material(rng);
  const float depth = rng.uniform(0.5f, std::max(back - 0.6f, 0.6f));
  build.box({x, 0.22f, -depth - 0.3f}, {0.8f, 0.22f, 0.4f}, cloth);
  build.box({x, 0.5f, -depth - 0.65f}, {0.8f, 0.4f, 0.12f}, cloth);
  for (int k = 0; k < 2; ++k)
    build.box({x - 0.4f + 0.8f * static_cast<float>(k), 0.56f, -depth - 0.45f}, {0.22f, 0.18f, 0.08f},
              cloth_material(rng), 0.2f);
}

/// A table or a cupboard.
void add_table(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const Material wood = wall_material(rng);
  build.box({x, 0.4f, -rng.uniform(0.7f, std::max(back - 0.3f, 0.8f))},
            {rng.uniform(0.3f, 0.8f), rng.uniform(0.3f, 0.6f), 0.25f}, wood, rng.uniform(-0.5f, 0.5f));
}

void add_potted_plant(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  add_plant(build, rng, {x, 0, -rng.uniform(0.6f, std::max(back - 0.3f, 0.7f))});
}

void add_lamp(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const vec3 at(x, rng.uniform(1.3f, 2), -rng.uniform(0.6f, std::max(back - 0.2f, 0.7f)));
  add_tube(build.object(plain_material(vec3(0.1f))), {vec3(at.x, 0, at.z), at}, {0.012f, 0.012f}, 5);
  add_tube(build.object(emissive_material(vec3(3, 2.3f, 1.4f) * rng.uniform(0.5f, 2))), {at, at + vec3(0, 0.25f, 0)},
           {0.2f, 0.12f}, 12);
}

/// A screen, a clock or a notice.
void add_wall_mounted_box(EnvironmentBuilder& build, RandomStream& rng, float x, float back) {
  const float z = -back + 0.02f;
  const float y = rng.uniform(0.8f, 1.8f);
  build.box({x, y, z + 0.03f}, {rng.uniform(0.1f, 0.5f), rng.uniform(0.1f, 0.35f), 0.03f},
            rng.chance(0.5f) ? plain_material(vec3(0.02f), 0.5f) : wall_material(rng));
}

/// Furniture at `x`, in front of or on the back wall, which is at -back.
constexpr void (*kFurniture[])(EnvironmentBuilder& build, RandomStream& rng, float x, float back) = {
    add_picture,      add_window, add_bookshelf,       add_door, add_sofa, add_table,
    add_potted_plant, add_lamp,   add_wall_mounted_box};
constexpr int kBookshelf = 2, kTable = 5;

}  // namespace

void add_room(EnvironmentBuilder& build, RandomStream& rng, float back, bool library) {
  const float half = rng.uniform(2, 5), tall = rng.uniform(2.3f, 3.2f), front = 5;
  const Material wall = wall_material(rng);
  Material floor = wall_material(rng);
  if (rng.chance(0.6f)) {
    floor.kind = Material::Kind::planks;
    floor.scale_m = rng.uniform(0.08f, 0.2f);
    floor.a = vec3(0.36f, 0.2f, 0.1f) * rng.uniform(0.4f, 1.6f), floor.c = 0.5f * floor.a;
  }
  build.quad({-half, 0, -back}, {2 * half, 0, 0}, {0, tall, 0}, wall);
  build.quad({-half, 0, front}, {2 * half, 0, 0}, {0, 0, -front - back}, floor);
  build.quad({-half, tall, -back}, {2 * half, 0, 0}, {0, 0, front + back},
             plain_material(vec3(rng.uniform(0.6f, 0.9f))));
  Material side_wall = rng.chance(0.7f) ? wall : wall_material(rng);
  build.quad({-half, 0, front}, {0, 0, -front - back}, {0, tall, 0}, side_wall);
  build.quad({half, 0, -back}, {0, 0, front + back}, {0, tall, 0}, side_wall);
  // furniture on and in front of the back wall
  const int things = library ? 7 : 2 + rng.below(5);
  for (int i = 0; i < things; ++i) {
    const float x = rng.uniform(-0.8f, 0.8f) * half;
    const int kind = library ? (i % 2 == 0 ? kBookshelf : kTable) : rng.below(static_cast<int>(std::size(kFurniture)));
    kFurniture[kind](build, rng, x, back);
  }
}

}  // namespace dualpixel::scenes
