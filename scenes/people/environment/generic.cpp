#include "scenes/people/environment/environments.h"

#include <algorithm>
#include <cmath>

#include "scenes/people/environment/plants.h"

namespace dualpixel::scenes {
namespace {

/// The same random shape at each of `positions`; it reaches up to 1.5 `size_m` from there.
void add_things(EnvironmentBuilder& build, RandomStream& rng, const std::vector<vec3>& positions, float size_m) {
  Material material = rng.chance(0.5f) ? wall_material(rng) : cloth_material(rng);
  const vec3 half = size_m * rng.uniform3(0.15f, 1), along = size_m * rng.uniform3(-1, 1),
             rest_shift = rng.uniform3(0, 1);
  const mat3 axes = rotation_about_y(rng.uniform(-1.5f, 1.5f));
  const float radius = 0.2f * half.x, middle_radius = radius * rng.uniform(0.5f, 1.5f);
  enum { kBox, kBall, kSheet, kTube, kShapes };
  const int shape = rng.below(kShapes);
  if (shape == kBall) material.scale_m /= half.y;  // rest positions of an ellipsoid have radius 1
  SceneObject& object = build.object(material);
  for (const vec3& at : positions) {
    switch (shape) {
      case kBox:
        add_box(object, at, axes, half, rest_shift);
        break;
      case kBall:
        add_ellipsoid(object, at, half, mat3(1), 7);
        break;
      case kSheet:
        add_quad(object, at - vec3(half.x, half.y, 0), vec3(2 * half.x, 0, half.z), vec3(0, 2 * half.y, -half.z),
                 rest_shift);
        break;
      default:
        add_tube(object, {at - along, at - along, at, at + along, at + along}, {0, radius, middle_radius, radius, 0},
                 7);
    }
  }
}

}  // namespace

void add_painted_backdrop(EnvironmentBuilder& build, RandomStream& rng, float back) {
  Material material = wall_material(rng);
  if (rng.chance(0.6f)) {
    constexpr Material::Kind kKinds[] = {Material::Kind::collage, Material::Kind::foliage, Material::Kind::crowd,
                                         Material::Kind::rough};
    material.kind = kKinds[rng.below(4)];
    material.scale_m = rng.uniform(0.15f, 0.9f);
    if (material.kind == Material::Kind::foliage) material.a = leaves_material(rng).a, material.c = 1.5f * material.a;
  }
  build.quad({-12, -1, -back}, {24, 0, 0}, {0, 9, 0}, material);
  build.quad({-12, 0, 5}, {24, 0, 0}, {0, 0, -back - 5}, wall_material(rng));
  const int things = rng.below(7);
  for (int i = 0; i < things; ++i) {
    const bool box = rng.chance(0.5f);
    const vec3 half = box ? rng.uniform3(0.05f, 0.5f) : vec3(rng.uniform(0.05f, 0.4f));
    // behind the people, however it is turned
    const float z = -std::max(rng.uniform(0.35f, 1) * back, 0.5f + (box ? std::hypot(half.x, half.z) : half.x));
    const vec3 at(rng.uniform(-1.5f, 1.5f) * (1 - 0.3f * z), rng.uniform(0.2f, 2), z);
    if (box) {
      build.box(at, half, wall_material(rng), rng.uniform(-1, 1));
    } else {
      add_ellipsoid(build.object(wall_material(rng)), at, half, mat3(1), 10);
    }
  }
}

void add_ground(EnvironmentBuilder& build, RandomStream& rng, float deepest_m) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -50}, wall_material(rng));
  if (!rng.chance(0.7f)) return;
  const float z = -deepest_m - rng.uniform(0.5f, 8);
  build.quad({-20, 0, z}, {40, 0, 0}, {0, 9, 0}, wall_material(rng));
}

void add_jumble(EnvironmentBuilder& build, RandomStream& rng, float back, int things) {
  for (int i = 0; i < things; ++i) {
    const float size_m = rng.uniform(0.08f, kLargestInJumble_m), z = -1.5f * size_m - 0.5f - rng.uniform(0, 1) * back;
    const float x = rng.uniform(-1, 1) * (1 - 0.7f * z), y = rng.uniform(0, 2.4f);
    add_things(build, rng, {{x, y, z}}, size_m);
  }
}

float add_rows(EnvironmentBuilder& build, RandomStream& rng, float back) {
  const int kinds = 1 + rng.below(3);
  float deepest_m = back;
  for (int k = 0; k < kinds; ++k) {
    const float across = rng.uniform(0.12f, 1.2f), upwards = rng.uniform(0.2f, 1.2f), inwards = rng.uniform(0.4f, 2);
    const int aside = 4, up = rng.chance(0.5f) ? 1 : 4, deep = 1 + rng.below(3);
    const float low = rng.uniform(0, 1.2f), size_m = rng.uniform(0.25f, 0.7f) * std::min(across, upwards);
    const float first = -back * rng.uniform(0.6f, 1) - 0.5f - size_m;
    std::vector<vec3> positions;
    for (int z = 0; z < deep; ++z) {
      for (int y = 0; y < up; ++y) {
        for (int x = -aside; x <= aside; ++x) {
          positions.emplace_back(across * static_cast<float>(x), low + upwards * static_cast<float>(y),
                                 first - inwards * static_cast<float>(z));
        }
      }
    }
    deepest_m = std::max(deepest_m, 1.5f * size_m - positions.back().z);
    add_things(build, rng, positions, size_m);
  }
  return deepest_m;
}

}  // namespace dualpixel::scenes
