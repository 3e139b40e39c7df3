#include "scenes/people/places/surroundings.h"

#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace dualpixel::scenes {
namespace {

using Kind = Material::Kind;

mat3 about_y(float angle) { return mat3(glm::rotate(glm::mat4(1), angle, vec3(0, 1, 0))); }

/// What builds one place, piece by piece.
class Builder {
 public:
  Builder(SceneModel& scene, RandomStream& rng) : scene_(scene), rng_(rng), first_(scene.objects.size()) {}

  SceneObject& object(const Material& material) {
    SceneObject& p = scene_.objects.emplace_back();
    p.material = scene_.add(material);
    return p;
  }
  void box(vec3 center, vec3 half, const Material& material, float yaw = 0) {
    add_box(object(material), center, about_y(yaw), half, rng_.uniform3(0, 1));
  }
  void quad(vec3 corner, vec3 a, vec3 b, const Material& material) { add_quad(object(material), corner, a, b); }
  /// Turns all that was built about the people.
  void turn(float yaw) {
    const mat3 axes = about_y(yaw);
    for (std::size_t i = first_; i < scene_.objects.size(); ++i) {
      for (vec3& p : scene_.objects[i].positions) p = axes * p;
      for (vec3& n : scene_.objects[i].normals) n = axes * n;
    }
  }

 private:
  SceneModel& scene_;
  RandomStream& rng_;
  std::size_t first_;
};

Material plain(vec3 color, float gloss = 0) {
  Material material;
  material.a = color;
  material.gloss = gloss;
  return material;
}

Material glowing(vec3 radiance) {
  Material material = plain(vec3(1));
  material.emission = radiance;
  return material;
}

Material leaves_material(RandomStream& rng) {
  Material material;
  material.kind = Kind::foliage;
  material.scale_m = rng.uniform(0.03f, 0.12f);
  material.seed = rng.seed();
  material.a = {rng.uniform(0.04f, 0.2f), rng.uniform(0.12f, 0.35f), rng.uniform(0.02f, 0.1f)};
  if (rng.chance(0.12f)) material.a = {rng.uniform(0.3f, 0.5f), rng.uniform(0.12f, 0.25f), 0.04f};  // autumn
  material.c = material.a * vec3(rng.uniform(0.6f, 2), rng.uniform(0.6f, 1.4f), rng.uniform(0.4f, 1.3f));
  material.softness = 0.4f;
  return material;
}

/// Leaves as single rhombi about the surface of an ellipsoid.
void add_leaves(SceneObject& object, RandomStream& rng, vec3 center, vec3 radii, int count, float leaf_m) {
  for (int i = 0; i < count; ++i) {
    const vec3 random = rng.uniform3(-1, 1);
    const vec3 out = glm::normalize(random + 0.001f);
    const vec3 p = center + radii * out * (0.6f + 0.45f * rng.uniform());
    const vec3 along = glm::normalize(out + 0.9f * rng.uniform3(-1, 1) - vec3(0, 0.3f, 0));
    const vec3 across = glm::normalize(glm::cross(along, out + 0.5f * rng.uniform3(-1, 1)) + 0.001f);
    const float length = leaf_m * rng.uniform(0.6f, 1.4f), half = 0.3f * length;
    const auto first = static_cast<unsigned>(object.positions.size());
    for (const vec3& q : {p, p + 0.5f * length * along + half * across, p + length * along,
                          p + 0.5f * length * along - half * across}) {
      object.positions.push_back(q);
      object.rest.push_back(vec3(q.x, q.y, q.z) + 0.7f * random);
      object.normals.push_back(glm::normalize(glm::cross(along, across) + 0.6f * out));
    }
    object.triangles.emplace_back(first, first + 1, first + 2);
    object.triangles.emplace_back(first, first + 2, first + 3);
  }
}

void add_tree(Builder& build, RandomStream& rng, vec3 foot, float tall) {
  Material bark;
  bark.kind = Kind::rough;
  bark.scale_m = 0.1f;
  bark.seed = rng.seed();
  bark.a = vec3(0.2f, 0.14f, 0.1f) * rng.uniform(0.4f, 1.6f);
  bark.b = 0.3f * bark.a;
  const vec3 top = foot + vec3(rng.uniform(-0.5f, 0.5f), tall, 0);
  add_tube(build.object(bark), {foot, glm::mix(foot, top, 0.5f) + rng.uniform3(-0.15f, 0.15f), top},
           {0.045f * tall, 0.03f * tall, 0.01f * tall}, 8);
  SceneObject& leaves = build.object(leaves_material(rng));
  for (int i = 0; i < 4; ++i) {
    add_leaves(leaves, rng, top + tall * 0.25f * rng.uniform3(-1, 1), tall * vec3(0.28f, 0.2f, 0.28f), 220,
               0.06f * tall);
  }
}

void add_plant(Builder& build, RandomStream& rng, vec3 foot) {
  const float tall = rng.uniform(0.4f, 1.4f);
  add_tube(build.object(plain(random_color(rng))), {foot, foot, foot + vec3(0, 0.25f, 0), foot + vec3(0, 0.25f, 0)},
           {0, 0.1f, 0.14f, 0}, 10);
  add_leaves(build.object(leaves_material(rng)), rng, foot + vec3(0, 0.25f + 0.5f * tall, 0),
             vec3(0.3f, 0.5f * tall, 0.3f), 120, rng.uniform(0.1f, 0.25f));
}

void add_room(Builder& build, RandomStream& rng, float back, bool library) {
  const float half = rng.uniform(2, 5), tall = rng.uniform(2.3f, 3.2f), front = 5;
  const Material wall = wall_material(rng);
  Material floor = wall_material(rng);
  if (rng.chance(0.6f)) {
    floor.kind = Kind::planks;
    floor.scale_m = rng.uniform(0.08f, 0.2f);
    floor.a = vec3(0.36f, 0.2f, 0.1f) * rng.uniform(0.4f, 1.6f), floor.c = 0.5f * floor.a;
  }
  build.quad({-half, 0, -back}, {2 * half, 0, 0}, {0, tall, 0}, wall);
  build.quad({-half, 0, front}, {2 * half, 0, 0}, {0, 0, -front - back}, floor);
  build.quad({-half, tall, -back}, {2 * half, 0, 0}, {0, 0, front + back}, plain(vec3(rng.uniform(0.6f, 0.9f))));
  Material side_wall = rng.chance(0.7f) ? wall : wall_material(rng);
  build.quad({-half, 0, front}, {0, 0, -front - back}, {0, tall, 0}, side_wall);
  build.quad({half, 0, -back}, {0, 0, front + back}, {0, tall, 0}, side_wall);
  // things on and before the back wall
  const int things = library ? 7 : 2 + rng.below(5);
  for (int i = 0; i < things; ++i) {
    const float x = rng.uniform(-0.8f, 0.8f) * half;
    const float z = -back + 0.02f;
    switch (library ? (i % 2 == 0 ? 2 : 5) : rng.below(9)) {
      case 0: {  // picture
        const vec3 size(rng.uniform(0.15f, 0.6f), rng.uniform(0.15f, 0.5f), 0.015f);
        const float y = rng.uniform(1.2f, 1.9f);
        build.box({x, y, z}, size + vec3(0.03f, 0.03f, -0.004f), plain(random_color(rng)));
        Material picture = wall_material(rng);
        picture.kind = Kind::collage;
        picture.scale_m = rng.uniform(0.1f, 0.5f);
        build.box({x, y, z}, size, picture);
        break;
      }
      case 1: {  // window
        const vec3 size(rng.uniform(0.4f, 1.1f), rng.uniform(0.5f, 0.9f), 0.02f);
        const float y = rng.uniform(1.2f, 1.8f);
        build.box({x, y, z}, size + vec3(0.06f, 0.06f, -0.005f), plain(vec3(rng.uniform(0.3f, 0.9f))));
        Material outside = rng.chance(0.5f) ? leaves_material(rng) : wall_material(rng);
        outside.emission = vec3(rng.uniform(1, 6));
        build.box({x, y, z}, size,
                  rng.chance(0.4f) ? glowing(vec3(rng.uniform(1.5f, 6)) * vec3(0.9f, 1, 1.1f)) : outside);
        for (const float bar : {-0.33f, 0.33f})
          build.box({x + bar * size.x, y, z + 0.02f}, {0.02f, size.y, 0.02f}, plain(vec3(0.7f)));
        if (rng.chance(0.5f)) {
          Material curtain = cloth_material(rng);
          curtain.kind = Kind::stripes_along;
          curtain.scale_m = 0.08f;
          curtain.b = 0.7f * curtain.a;
          for (const float s : {-1.0f, 1.0f})
            build.box({x + s * size.x, 1.3f, z + 0.06f}, {0.2f, 1.2f, 0.02f}, curtain);
        }
        break;
      }
      case 2: {  // shelf of books
        Material material;
        material.kind = Kind::books;
        material.scale_m = rng.uniform(0.03f, 0.06f);
        material.seed = rng.seed();
        material.a = vec3(0.36f, 0.22f, 0.12f) * rng.uniform(0.3f, 1.8f);
        material.b = 0.4f * material.a;
        const float high = rng.uniform(0.5f, 1.1f);
        build.box({x, high, z + 0.15f}, {rng.uniform(0.4f, 1.2f), high, 0.16f}, material);
        break;
      }
      case 3: {  // door
        build.box({x, 1, z}, {0.45f, 1.02f, 0.02f}, plain(random_color(rng), 0.1f));
        break;
      }
      case 4: {  // sofa
        const Material cloth = cloth_material(rng);
        const float depth = rng.uniform(0.5f, std::max(back - 0.6f, 0.6f));
        build.box({x, 0.22f, -depth - 0.3f}, {0.8f, 0.22f, 0.4f}, cloth);
        build.box({x, 0.5f, -depth - 0.65f}, {0.8f, 0.4f, 0.12f}, cloth);
        for (int k = 0; k < 2; ++k)
          build.box({x - 0.4f + 0.8f * static_cast<float>(k), 0.56f, -depth - 0.45f}, {0.22f, 0.18f, 0.08f},
                    cloth_material(rng), 0.2f);
        break;
      }
      case 5: {  // table, cupboard
        const Material wood = wall_material(rng);
        build.box({x, 0.4f, -rng.uniform(0.7f, std::max(back - 0.3f, 0.8f))},
                  {rng.uniform(0.3f, 0.8f), rng.uniform(0.3f, 0.6f), 0.25f}, wood, rng.uniform(-0.5f, 0.5f));
        break;
      }
      case 6:
        add_plant(build, rng, {x, 0, -rng.uniform(0.6f, std::max(back - 0.3f, 0.7f))});
        break;
      case 7: {  // lamp
        const vec3 at(x, rng.uniform(1.3f, 2), -rng.uniform(0.6f, std::max(back - 0.2f, 0.7f)));
        add_tube(build.object(plain(vec3(0.1f))), {vec3(at.x, 0, at.z), at}, {0.012f, 0.012f}, 5);
        add_tube(build.object(glowing(vec3(3, 2.3f, 1.4f) * rng.uniform(0.5f, 2))), {at, at + vec3(0, 0.25f, 0)},
                 {0.2f, 0.12f}, 12);
        break;
      }
      default: {  // screens, clocks, notices
        const float y = rng.uniform(0.8f, 1.8f);
        build.box({x, y, z + 0.03f}, {rng.uniform(0.1f, 0.5f), rng.uniform(0.1f, 0.35f), 0.03f},
                  rng.chance(0.5f) ? plain(vec3(0.02f), 0.5f) : wall_material(rng));
      }
    }
  }
}

void add_garden(Builder& build, RandomStream& rng, float back) {
  Material grass;
  grass.kind = rng.chance(0.7f) ? Kind::grass : Kind::paving;
  grass.a = vec3(rng.uniform(0.06f, 0.2f), rng.uniform(0.14f, 0.3f), rng.uniform(0.02f, 0.08f));
  if (grass.kind == Kind::paving) grass.a = vec3(rng.uniform(0.2f, 0.5f)), grass.b = 0.4f * grass.a;
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

void add_street(Builder& build, RandomStream& rng, float back) {
  Material ground = wall_material(rng);
  ground.kind = Kind::paving;
  ground.a = vec3(rng.uniform(0.1f, 0.5f)), ground.b = 0.5f * ground.a, ground.c = 0.8f * ground.a;
  ground.scale_m = rng.uniform(0.3f, 1);
  build.quad({-40, 0, 10}, {80, 0, 0}, {0, 0, -80}, ground);
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < 4; ++i) {
      Material house = wall_material(rng);
      if (rng.chance(0.75f)) house.kind = Kind::facade, house.scale_m = rng.uniform(1.4f, 3);
      const float depth = rng.uniform(2, 4), tall = rng.uniform(2.5f, 8);
      build.box({side * (rng.uniform(2.5f, 6) + 2), tall, -back - 8 * static_cast<float>(i)}, {2, tall, depth}, house);
    }
  }
  if (rng.chance(0.6f)) {
    Material house = wall_material(rng);
    house.kind = rng.chance(0.7f) ? Kind::facade : Kind::crowd;
    house.scale_m = house.kind == Kind::facade ? rng.uniform(1.4f, 3) : 0.5f;
    const float tall = house.kind == Kind::facade ? rng.uniform(3, 9) : 2.1f;
    build.box({0, tall, -back - rng.uniform(4, 25)}, {15, tall, 1}, house);
  }
  const int cars = rng.below(4);
  for (int i = 0; i < cars; ++i) {
    const Material paint = plain(random_color(rng), 0.5f);
    const float x = rng.uniform(-4, 4), z = -back - rng.uniform(1, 12), yaw = rng.chance(0.5f) ? 0.0f : 1.5f;
    build.box({x, 0.65f, z}, {2.1f, 0.38f, 0.85f}, paint, yaw);
    build.box({x, 1.2f, z}, {1.1f, 0.26f, 0.75f}, plain(vec3(0.03f), 0.7f), yaw);
  }
  const int posts = rng.below(4);
  for (int i = 0; i < posts; ++i) {
    const float x = rng.uniform(-3, 3), z = -back - rng.uniform(0, 8);
    add_tube(build.object(plain(vec3(rng.uniform(0.02f, 0.3f)))), {{x, 0, z}, {x, 5, z}}, {0.06f, 0.05f}, 8);
    if (rng.chance(0.4f)) build.box({x, rng.uniform(1.8f, 2.6f), z}, {0.35f, 0.35f, 0.02f}, wall_material(rng));
  }
  if (rng.chance(0.4f)) add_tree(build, rng, {rng.uniform(-4, 4), 0, -back - rng.uniform(1, 6)}, rng.uniform(2, 6));
}

void add_landscape(Builder& build, RandomStream& rng, float back) {
  Material ground = wall_material(rng);
  ground.kind = rng.chance(0.5f) ? Kind::grass : Kind::rough;
  ground.a = rng.chance(0.4f) ? vec3(0.5f, 0.42f, 0.3f) : vec3(0.15f, 0.25f, 0.08f) * rng.uniform(0.5f, 2);
  ground.c = ground.b = 0.6f * ground.a;
  build.quad({-200, 0, 10}, {400, 0, 0}, {0, 0, -400}, ground);
  if (rng.chance(0.5f))
    build.quad({-200, 0.01f, -back - 5}, {400, 0, 0}, {0, 0, -200}, plain(vec3(0.06f, 0.12f, 0.16f), 0.3f));
  const int hills = 2 + rng.below(3);
  for (int i = 0; i < hills; ++i) {
    SceneObject& hill =
        build.object(rng.chance(0.5f) ? leaves_material(rng) : plain(vec3(0.12f, 0.18f, 0.22f) * rng.uniform(0.5f, 2)));
    const float z = -30 - 20 * static_cast<float>(i), wide = rng.uniform(15, 40);
    add_ellipsoid(hill, {rng.uniform(-40, 40), -2, z}, {wide, rng.uniform(3, 14), 8}, mat3(1), 10);
  }
}

void add_lights_at_night(Builder& build, RandomStream& rng, float back) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -40}, plain(vec3(0.05f), 0.1f));
  build.quad({-30, 0, -back - 14}, {60, 0, 0}, {0, 20, 0}, wall_material(rng));
  const int lights = 30 + rng.below(60);
  for (int i = 0; i < lights; ++i) {
    const float z = -back - rng.uniform(1, 12);
    const vec3 color = rng.chance(0.5f) ? vec3(1, 0.75f, 0.4f) : random_color(rng) + 0.1f;
    add_ellipsoid(build.object(glowing(color * rng.uniform(4, 40))),
                  {rng.uniform(-0.5f, 0.5f) * (3 - z), rng.uniform(0.2f, 3.2f), z}, vec3(rng.uniform(0.01f, 0.07f)),
                  mat3(1), 4);
  }
}

void add_painted(Builder& build, RandomStream& rng, float back) {
  // anything at all, large: stands for what no other place has
  Material material = wall_material(rng);
  if (rng.chance(0.6f)) {
    constexpr Kind kKinds[] = {Kind::collage, Kind::foliage, Kind::crowd, Kind::rough};
    material.kind = kKinds[rng.below(4)];
    material.scale_m = rng.uniform(0.15f, 0.9f);
    if (material.kind == Kind::foliage) material.a = leaves_material(rng).a, material.c = 1.5f * material.a;
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

/// The same thing of no particular kind at each of `places`; it reaches up to 1.5 `size_m` from there.
void add_things(Builder& build, RandomStream& rng, const std::vector<vec3>& places, float size_m) {
  Material material = rng.chance(0.5f) ? wall_material(rng) : cloth_material(rng);
  const vec3 half = size_m * rng.uniform3(0.15f, 1), along = size_m * rng.uniform3(-1, 1),
             rest_shift = rng.uniform3(0, 1);
  const mat3 axes = about_y(rng.uniform(-1.5f, 1.5f));
  const float radius = 0.2f * half.x, middle_radius = radius * rng.uniform(0.5f, 1.5f);
  enum { kBox, kBall, kSheet, kTube, kShapes };
  const int shape = rng.below(kShapes);
  if (shape == kBall) material.scale_m /= half.y;  // a ball's rest places are of radius 1
  SceneObject& object = build.object(material);
  for (const vec3& at : places) {
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

/// Ground, and mostly a wall beyond `deepest_m`.
void add_ground(Builder& build, RandomStream& rng, float deepest_m) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -50}, wall_material(rng));
  if (!rng.chance(0.7f)) return;
  const float z = -deepest_m - rng.uniform(0.5f, 8);
  build.quad({-20, 0, z}, {40, 0, 0}, {0, 9, 0}, wall_material(rng));
}

constexpr float kLargestInJumble_m = 0.6f;

/// Anything, anywhere behind the people.
void add_jumble(Builder& build, RandomStream& rng, float back, int things) {
  for (int i = 0; i < things; ++i) {
    const float size_m = rng.uniform(0.08f, kLargestInJumble_m), z = -1.5f * size_m - 0.5f - rng.uniform(0, 1) * back;
    const float x = rng.uniform(-1, 1) * (1 - 0.7f * z), y = rng.uniform(0, 2.4f);
    add_things(build, rng, {{x, y, z}}, size_m);
  }
}

/// The same thing again and again, in rows: shelves, stalls, seats, fences, lamps. Returns how far back they reach.
float add_rows(Builder& build, RandomStream& rng, float back) {
  const int kinds = 1 + rng.below(3);
  float deepest_m = back;
  for (int k = 0; k < kinds; ++k) {
    const float across = rng.uniform(0.12f, 1.2f), upwards = rng.uniform(0.2f, 1.2f), inwards = rng.uniform(0.4f, 2);
    const int aside = 4, up = rng.chance(0.5f) ? 1 : 4, deep = 1 + rng.below(3);
    const float low = rng.uniform(0, 1.2f), size_m = rng.uniform(0.25f, 0.7f) * std::min(across, upwards);
    const float first = -back * rng.uniform(0.6f, 1) - 0.5f - size_m;
    std::vector<vec3> places;
    for (int z = 0; z < deep; ++z) {
      for (int y = 0; y < up; ++y) {
        for (int x = -aside; x <= aside; ++x) {
          places.emplace_back(across * static_cast<float>(x), low + upwards * static_cast<float>(y),
                              first - inwards * static_cast<float>(z));
        }
      }
    }
    deepest_m = std::max(deepest_m, 1.5f * size_m - places.back().z);
    add_things(build, rng, places, size_m);
  }
  return deepest_m;
}

void add_market(Builder& build, RandomStream& rng, float back) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -40}, wall_material(rng));
  build.quad({-20, 0, -back - 8}, {40, 0, 0}, {0, 9, 0}, wall_material(rng));
  for (int i = 0; i < 6; ++i) {
    const float x = rng.uniform(-4, 4), z = -back - rng.uniform(0, 5);
    Material awning = cloth_material(rng);
    awning.kind = Kind::stripes_along;
    awning.scale_m = 0.3f;
    build.quad({x - 1, 2.1f, z}, {2, 0, 0}, {0, 0.5f, -1.2f}, awning);
    build.box({x, 0.45f, z - 0.4f}, {1, 0.45f, 0.4f}, wall_material(rng));
    SceneObject& goods = build.object(cloth_material(rng));
    for (int k = 0; k < 25; ++k)
      add_ellipsoid(goods, {x + rng.uniform(-0.9f, 0.9f), 0.95f, z - rng.uniform(0.1f, 0.7f)},
                    vec3(rng.uniform(0.04f, 0.1f)), mat3(1), 4);
  }
}

/// What closes it off stands about `back` behind the people.
void add_kind(Builder& build, RandomStream& rng, EnvironmentKind place, float back) {
  switch (place) {
    case EnvironmentKind::studio: {
      Material material = plain(random_color(rng));
      if (rng.chance(0.4f)) {
        material.kind = Kind::rough;
        material.scale_m = rng.uniform(0.3f, 1.5f);
        material.b = material.a * rng.uniform(0.5f, 0.9f);
        material.seed = rng.seed();
      }
      build.quad({-15, -1, -back}, {30, 0, 0}, {0, 12, 0}, material);
      build.quad({-15, 0, 6}, {30, 0, 0}, {0, 0, -6 - back}, material);
      break;
    }
    case EnvironmentKind::room:
      add_room(build, rng, back, false);
      break;
    case EnvironmentKind::library:
      add_room(build, rng, back, true);
      break;
    case EnvironmentKind::wall: {
      const float z = -0.35f - 0.4f * back * rng.uniform();
      build.quad({-15, 0, z}, {30, 0, 0}, {0, 8, 0}, wall_material(rng));
      build.quad({-15, 0, 6}, {30, 0, 0}, {0, 0, -12}, wall_material(rng));
      if (rng.chance(0.3f)) build.box({rng.uniform(-1.5f, 1.5f), 1.2f, z}, {0.5f, 1.2f, 0.04f}, wall_material(rng));
      break;
    }
    case EnvironmentKind::garden:
      add_garden(build, rng, back);
      break;
    case EnvironmentKind::street:
      add_street(build, rng, back);
      break;
    case EnvironmentKind::painted:
      add_painted(build, rng, back);
      break;
    case EnvironmentKind::landscape:
      add_landscape(build, rng, back);
      break;
    case EnvironmentKind::night:
      add_lights_at_night(build, rng, back);
      break;
    case EnvironmentKind::jumble:
      add_ground(build, rng, back + 0.5f + 3 * kLargestInJumble_m);
      add_jumble(build, rng, back, 8 + rng.below(40));
      break;
    case EnvironmentKind::rows:
      add_ground(build, rng, add_rows(build, rng, back));
      break;
    case EnvironmentKind::mixed: {  // things before whatever closes an ordinary place off
      constexpr EnvironmentKind kOrdinary[] = {EnvironmentKind::studio,    EnvironmentKind::room,
                                               EnvironmentKind::garden,    EnvironmentKind::street,
                                               EnvironmentKind::landscape, EnvironmentKind::painted};
      const float behind_m = back + (1.5f * kLargestInJumble_m + 0.7f);  // most of what comes at 0.4 back
      add_kind(build, rng, kOrdinary[rng.below(static_cast<int>(std::size(kOrdinary)))], behind_m);
      if (rng.chance(0.6f)) add_rows(build, rng, 0.4f * back);
      add_jumble(build, rng, 0.4f * back, rng.below(16));
      break;
    }
    case EnvironmentKind::market:
      add_market(build, rng, back);
      break;
  }
}

}  // namespace

std::string add_environment(SceneModel& scene, RandomStream rng, float back_m) {
  constexpr const char* kNames[] = {"studio", "room",   "wall", "garden", "street", "painted", "landscape",
                                    "night",  "jumble", "rows", "mixed",  "market", "library"};
  static_assert(std::size(kNames) == kEnvironmentKinds &&
                static_cast<int>(EnvironmentKind::library) == kEnvironmentKinds - 1);
  constexpr EnvironmentKind kStrange[] = {EnvironmentKind::painted, EnvironmentKind::jumble, EnvironmentKind::rows,
                                          EnvironmentKind::mixed, EnvironmentKind::mixed};
  const EnvironmentKind place =
      rng.domain_randomized() && rng.chance(0.6f)
          ? kStrange[rng.below(static_cast<int>(std::size(kStrange)))]
          : static_cast<EnvironmentKind>(rng.choose(kEnvironmentKinds, kReservedEnvironmentKinds));
  Builder build(scene, rng);
  scene.dome.seed = rng.seed();
  add_kind(build, rng, place, back_m);
  build.turn(0.22f * rng.normal());
  return std::string("place:") + kNames[static_cast<int>(place)];
}

std::string set_lighting(SceneModel& scene, RandomStream rng) {
  constexpr const char* kNames[] = {"overcast", "sun",  "sun behind", "window", "ceiling", "softbox",
                                    "flash",    "lamp", "neon",       "golden", "skylight"};
  const int index = rng.choose(kLightingKinds, kReservedLightingKinds);
  const float side = rng.sign(), turn = rng.uniform(0.2f, 1.3f), up = rng.uniform(0.25f, 1.1f);
  const auto towards = [](float around, float height) {
    return vec3(std::sin(around) * std::cos(height), std::sin(height), std::cos(around) * std::cos(height));
  };
  const vec3 sky = glm::mix(vec3(0.55f, 0.75f, 1.1f), vec3(0.9f, 0.95f, 1), rng.uniform());
  const vec3 warm = glm::mix(vec3(1, 0.93f, 0.84f), vec3(1, 0.62f, 0.33f), rng.uniform());
  DomeLight& dome = scene.dome;
  KeyLight& key = scene.key;
  key.direction = towards(side * turn, up);
  dome.lobe_direction = key.direction;
  dome.sky = true;
  const vec3 ground = vec3(0.35f, 0.32f, 0.28f) * rng.uniform(0.4f, 1.2f);
  switch (static_cast<LightingKind>(index)) {
    case LightingKind::overcast:
      dome.up = vec3(1.1f), dome.horizon = vec3(0.75f), dome.down = ground * 0.6f;
      key.irradiance = vec3(rng.uniform(0.05f, 0.25f)), key.spread = 0.3f;
      break;
    case LightingKind::sun_side:
      dome.up = 0.4f * sky, dome.horizon = 0.6f * sky, dome.down = ground;
      key.irradiance = vec3(1.6f, 1.5f, 1.35f) * rng.uniform(0.6f, 1.2f), key.spread = 0.02f;
      break;
    case LightingKind::sun_behind:
      dome.up = 0.6f * sky, dome.horizon = 0.8f * sky, dome.down = ground;
      key.direction = towards(side * rng.uniform(2, 3.1f), rng.uniform(0.3f, 1));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1, 0.95f, 0.8f) * rng.uniform(0.5f, 3);
      key.irradiance = vec3(2, 1.85f, 1.6f), key.spread = 0.02f;
      break;
    case LightingKind::window:
      dome.up = vec3(0.35f), dome.horizon = vec3(0.3f), dome.down = ground * 0.6f;
      key.direction = towards(side * rng.uniform(0.9f, 1.8f), rng.uniform(0.0f, 0.6f));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1, 1, 1.05f) * rng.uniform(0.6f, 2);
      key.irradiance = vec3(0.9f, 0.95f, 1), key.spread = rng.uniform(0.1f, 0.35f);
      break;
    case LightingKind::ceiling:
      dome.up = warm * 0.8f, dome.horizon = warm * 0.5f, dome.down = ground;
      key.direction = towards(side * rng.uniform(0, 2.5f), rng.uniform(0.9f, 1.4f));
      key.irradiance = warm * rng.uniform(0.3f, 0.9f), key.spread = rng.uniform(0.06f, 0.3f);
      break;
    case LightingKind::softbox:
      dome.up = vec3(0.25f), dome.horizon = vec3(0.25f), dome.down = vec3(0.2f);
      key.irradiance = vec3(1), key.spread = rng.uniform(0.08f, 0.3f);
      break;
    case LightingKind::flash:
      dome.up = dome.horizon = vec3(rng.uniform(0.05f, 0.2f)), dome.down = vec3(0.05f);
      key.direction = towards(side * rng.uniform(0, 0.12f), rng.uniform(0.0f, 0.2f));
      key.irradiance = vec3(1.1f), key.spread = 0.02f;
      break;
    case LightingKind::lamp:
      dome.up = warm * 0.12f, dome.horizon = warm * 0.15f, dome.down = ground * 0.3f;
      key.direction = towards(side * rng.uniform(0.5f, 2), rng.uniform(-0.1f, 0.8f));
      key.irradiance = warm * 1.2f, key.spread = rng.uniform(0.05f, 0.3f);
      break;
    case LightingKind::golden:
      dome.up = vec3(0.3f, 0.42f, 0.65f), dome.horizon = vec3(0.9f, 0.6f, 0.4f), dome.down = ground;
      key.direction = towards(side * rng.uniform(0.3f, 2.7f), rng.uniform(0.05f, 0.3f));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1.5f, 0.9f, 0.4f);
      key.irradiance = vec3(1.6f, 1, 0.55f), key.spread = 0.04f;
      break;
    case LightingKind::neon: {
      const vec3 one = random_color(rng) + 0.1f, two = random_color(rng) + 0.1f;
      dome.up = vec3(0.08f), dome.horizon = 0.3f * one, dome.down = vec3(0.05f);
      dome.lobe_direction = towards(-side * rng.uniform(0.8f, 2), 0.2f), dome.lobe = 2.0f * one,
      dome.lobe_sharpness = 2;
      key.irradiance = 1.5f * two, key.spread = 0.2f;
      break;
    }
    case LightingKind::skylight:
      dome.up = vec3(1.6f, 1.6f, 1.7f), dome.horizon = vec3(0.2f), dome.down = ground * 0.8f;
      key.direction = towards(side, 1.35f);
      key.irradiance = vec3(0.5f), key.spread = 0.35f;
      break;
  }
  return std::string("light:") + kNames[index];
}

void add_foreground(SceneModel& scene, RandomStream rng, vec3 camera, float top_m) {
  Builder build(scene, rng);
  const float between = rng.uniform(0.25f, 0.6f);
  const vec3 at = camera * between;
  switch (rng.below(4)) {
    case 0: {  // the near edge of a table
      const float y = top_m - rng.uniform(0.02f, 0.12f);
      build.box({at.x, y - 0.02f, 0.35f + at.z * 0.5f}, {2.5f, 0.02f, std::max(at.z * 0.5f - 0.1f, 0.1f)},
                wall_material(rng));
      for (int i = 0; i < 3; ++i) {
        const vec3 half = rng.uniform3(0.02f, 0.06f);
        build.box({at.x + rng.uniform(-0.4f, 0.4f), y + half.y, 0.35f + at.z * rng.uniform(0.2f, 0.6f)}, half,
                  cloth_material(rng), rng.uniform(-1, 1));
      }
      break;
    }
    case 1:  // leaves from one side or below
      add_leaves(build.object(leaves_material(rng)), rng,
                 {at.x + rng.sign() * rng.uniform(0.15f, 0.4f), top_m - rng.uniform(0.0f, 0.2f), at.z}, vec3(0.18f), 40,
                 0.09f);
      break;
    case 2: {  // rail
      const float y = top_m - rng.uniform(0.0f, 0.15f);
      const Material metal = plain(random_color(rng), 0.3f);
      add_tube(build.object(metal), {{at.x - 3, y, at.z}, {at.x + 3, y, at.z}}, {0.02f, 0.02f}, 6);
      for (int i = -6; i < 7; ++i) {
        const float x = at.x + 0.14f * static_cast<float>(i);
        add_tube(build.object(metal), {{x, 0, at.z}, {x, y, at.z}}, {0.007f, 0.007f}, 5);
      }
      break;
    }
    default:  // somebody's shoulder, a cushion, a dog's back
      add_ellipsoid(build.object(cloth_material(rng)),
                    {at.x + rng.sign() * rng.uniform(0.15f, 0.4f), top_m - rng.uniform(0.12f, 0.3f), at.z},
                    vec3(0.17f, 0.14f, 0.1f), mat3(1), 12);
  }
}

}  // namespace dualpixel::scenes
