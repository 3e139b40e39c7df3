#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/places/places.h"
#include "scenes/procedural/noise.h"
#include "scenes/shapes/plants.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

/// Level near the camera, rolling farther away, hills at the end.
void add_meadow(SceneBuilder& build, RandomStream rng, float farthest) {
  const std::uint32_t seed = rng.seed();
  Mesh ground;
  add_sheet(ground, 90, 120, {1, 1}, [&](float u, float v) {
    const float z = 6 - std::pow(v, 2.2f) * (2.6f * farthest), x = (2 * u - 1) * (8 - z);
    const float away = std::min(std::max(-z - 12, 0.0f) / farthest, 1.5f);
    return vec3(x,
                0.02f * noise(seed, vec3(x, z, 0)) +
                    away * away * 14 * (noise(seed + 1, vec3(x, z, 3) * 0.02f) - 0.35f) - 0.01f,
                z);
  });
  for (std::size_t i = 0; i < ground.uvs.size(); ++i) ground.uvs[i] = {ground.positions[i].x, ground.positions[i].z};
  const vec3 green = vec3(0.07f, 0.11f, 0.03f) * rng.uniform(0.6f, 1.5f);
  build.add("meadow", ground,
            rough_surface(rng.substream(1), green * vec3(rng.uniform(0.9f, 1.9f), 1, 1), 0.35f, 1.7f, 1.1f));
}

void add_path(SceneBuilder& build, RandomStream rng) {
  const float wide = rng.uniform(0.6f, 1.4f), bend = rng.uniform(-3, 3), from = rng.uniform(-1, 1);
  Mesh path;
  add_sheet(path, 4, 60, {2 * wide, 30}, [&](float u, float v) {
    const float z = 3 - 30 * v;
    return vec3(from + bend * v * v + (2 * u - 1) * wide, 0.035f, z);
  });
  const vec3 stone = vec3(0.3f, 0.28f, 0.25f) * rng.uniform(0.7f, 1.3f);
  build.add("path", path,
            rng.chance(0.5f) ? tile_surface(rng.substream(1), stone, stone * 0.4f, {0.2f, 0.1f}, 0.2f)
                             : rough_surface(rng.substream(1), stone, 0.25f, 1, 1.1f));
}

void add_grass_near(SceneBuilder& build, RandomStream rng) {
  Mesh blades;
  add_grass(blades, rng.substream(1), 900, 0.5f, rng.uniform(0.04f, 0.14f));
  const vec3 green = vec3(0.05f, 0.1f, 0.02f) * rng.uniform(0.8f, 1.5f);
  const int shared =
      build.add_shared({{blades, build.add(leaf_surface(rng.substream(2), green, green * vec3(2, 1.5f, 1)))}});
  for (int i = 0; i < 260; ++i) {
    const float z = -0.5f - 13 * std::pow(rng.uniform(), 1.3f), x = rng.uniform(-1, 1) * (1.2f + 0.7f * -z);
    plant(build, rng, "grass", shared, {x, 0, z}, 1);
  }
}

/// Away from the axis where that is to be clear.
float beside(RandomStream& rng, float half_width, float clear) {
  const float x = rng.uniform(-half_width, half_width);
  return std::abs(x) < clear ? std::copysign(clear + 0.3f * half_width * rng.uniform(), x) : x;
}

/// Low plants in patches, from the foreground on.
void add_beds(SceneBuilder& build, RandomStream rng, const Planting& planting, const PlaceOptions& options) {
  const int beds = 3 + rng.below(4);
  for (int i = 0; i < beds; ++i) {
    const float z = options.nearest_m + 0.6f + 9 * rng.uniform() * rng.uniform(),
                x = beside(rng, 0.5f + 0.5f * z, options.clear_m + 0.6f), wide = rng.uniform(0.5f, 1.6f);
    const int shared = planting.shrubs[static_cast<std::size_t>(rng.below(static_cast<int>(planting.shrubs.size())))];
    const int plants = 5 + rng.below(9);
    for (int k = 0; k < plants; ++k)
      plant(build, rng, "bed", shared, {x + wide * rng.uniform(-1, 1), -0.02f, -z - rng.uniform(0, 0.9f)},
            rng.uniform(0.25f, 0.55f));
  }
}

}  // namespace

void lay_garden(SceneBuilder& build, RandomStream rng, const PlaceOptions& options) {
  add_meadow(build, rng.substream(1), options.farthest_m);
  if (rng.chance(0.6f)) add_path(build, rng.substream(2));
  add_grass_near(build, rng.substream(3));
  const Planting planting = grow_planting(build, rng.substream(4), 2);
  RandomStream at = rng.substream(5);
  for (int i = 0; i < options.trees; ++i) {
    const float t = (static_cast<float>(i) + at.uniform()) / static_cast<float>(options.trees);
    const float z = options.nearest_m + 3 + t * t * (0.7f * options.farthest_m - 3);
    plant(build, at, "tree", planting.trees[static_cast<std::size_t>(at.below(2))],
          {beside(at, 1 + 0.55f * z, options.clear_m + 0.4f), 0, -z}, 1);
  }
  const int edge = std::min(6 + 2 * options.trees, 40);
  for (int i = 0; i < edge; ++i) {  // the wood's edge
    const float x =
        (2 * (static_cast<float>(i) + at.uniform()) / static_cast<float>(edge) - 1) * 0.6f * options.farthest_m;
    plant(build, at, "tree", planting.trees[static_cast<std::size_t>(at.below(2))],
          {x, -0.3f, -options.farthest_m * at.uniform(0.7f, 1)}, 1.3f);
  }
  for (int i = 0; i < 8 + 3 * options.trees; ++i) {
    const float z = options.nearest_m + 1 + 22 * at.uniform() * at.uniform();
    plant(build, at, "shrub", planting.shrubs[static_cast<std::size_t>(at.below(2))],
          {beside(at, 0.6f + 0.6f * z, options.clear_m + 0.5f), 0, -z}, 1);
  }
  add_beds(build, rng.substream(9), planting, options);
  if (at.chance(0.5f)) {
    const float z = -at.uniform(5, 12), tilt = at.uniform(-2, 2), side = at.sign();
    add_fence(build, rng.substream(6), {side * 7, 0, z + tilt}, {-side * at.uniform(-0.5f, 7), 0, z - tilt});
  }
  if (at.chance(0.45f)) {
    const int house =
        build_house(build, rng.substream(7), at.uniform(6, 12), at.uniform(3.4f, 7), lamp_nits(options.light) > 0);
    build.place("house", house, standing({at.sign() * at.uniform(3, 9), 0, -at.uniform(12, 26)}, 0.4f * at.normal()));
  }
  if (at.chance(0.5f))
    add_bench(build, rng.substream(8),
              standing({beside(at, 2, options.clear_m + 0.6f), 0, -at.uniform(2.5f, 6)}, 0.5f * at.normal()));
  const float nits = lamp_nits(options.light);
  for (int i = 0; i < options.lamps; ++i) {
    const float z =
        options.nearest_m + 3 + 30 * (static_cast<float>(i) + at.uniform()) / static_cast<float>(options.lamps);
    add_lamp_post(build, rng.substream(20 + i), {beside(at, 0.8f + 0.35f * z, options.clear_m + 0.5f), 0, -z}, nits);
  }
}

}  // namespace dualpixel::scenes
