#include "scenes/people/held/things.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/people/shape/primitives.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {

/// On a shoulder, across the chest or at the side.
void add_bag(Holding& hold, RandomStream& rng) {
  const int side = hold.figure.pose.held_side;
  const bool across = rng.chance(0.45f);
  const float x = side == 0 ? 1.0f : -1.0f;
  const vec3 shoulder = glm::mix(hold.figure.skeleton.shoulder[side], hold.figure.skeleton.neck_base, 0.3f) +
                        kUp * (0.05f * hold.figure.body.stature_m * (1 + 0.1f * hold.figure.body.girth));
  const vec3 low = across ? hold.figure.skeleton.pelvis.to_world({-x * 0.13f * hold.figure.body.stature_m,
                                                                  0.02f * hold.figure.body.stature_m,
                                                                  0.05f * hold.figure.body.stature_m})
                          : hold.figure.skeleton.pelvis.to_world({x * 0.15f * hold.figure.body.stature_m,
                                                                  0.06f * hold.figure.body.stature_m,
                                                                  0.02f * hold.figure.body.stature_m});
  std::vector<vec3> path;
  for (int i = 0; i <= 8; ++i) {
    const float t = static_cast<float>(i) / 8;
    vec3 p = glm::mix(shoulder, low, t) + hold.forward * ((across ? 0.075f : 0.05f) * hold.figure.body.stature_m *
                                                          std::sqrt(std::max(std::sin(3.1f * t), 0.0f)));
    for (int step = 0; step < 3; ++step) {  // outside the body
      const float room = 0.03f - hold.figure.bare(p);
      if (room > 0) p += hold.forward * room;
    }
    path.push_back(p);
  }
  add_tube(hold.object, path, std::vector<float>(path.size(), rng.uniform(0.008f, 0.02f)), 6);
  const vec3 half(rng.uniform(0.04f, 0.07f), rng.uniform(0.08f, 0.16f), rng.uniform(0.1f, 0.17f));
  add_box(hold.object, low - kUp * half.y, hold.figure.skeleton.pelvis.axes, half);
  hold.material.kind = rng.chance(0.3f) ? Material::Kind::checks : Material::Kind::plain;
  hold.material.gloss = 0.15f;
}

void add_bouquet(Holding& hold, RandomStream& rng) {
  Material leaves = glossy_material(rng, 0.1f);
  leaves.kind = Material::Kind::foliage;
  leaves.scale_m = 0.02f;
  leaves.a = {0.1f, 0.22f, 0.06f};
  leaves.c = {0.2f, 0.35f, 0.1f};
  SceneObject stems;
  for (int i = 0; i < 45; ++i) {
    const vec3 out = glm::normalize(rng.uniform3(-1, 1) + vec3(0, 1.3f, 0));
    const vec3 at = hold.grip + out * rng.uniform(0.1f, 0.22f);
    add_ellipsoid(i % 3 == 0 ? stems : hold.object, at, vec3(1, 0.6f, 1) * rng.uniform(0.01f, 0.03f),
                  axes_along(out, hold.forward), 5);
  }
  add_tube(stems, {hold.grip - 0.12f * kUp, hold.grip, hold.grip + 0.1f * kUp}, {0.012f, 0.02f, 0.06f}, 8);
  add_object(hold.scene, hold.figure, std::move(stems), leaves);
  hold.material.kind = Material::Kind::heather;
}

/// The size of a dog or cat: body, head with muzzle and ears, legs, all fur.
void add_pet(Holding& hold, RandomStream& rng) {
  const float size = rng.uniform(0.75f, 1.3f), x = hold.figure.pose.held_side == 0 ? 1.0f : -1.0f;
  const Frame frame{hold.grip + 0.05f * hold.forward, hold.figure.skeleton.chest.axes};
  const auto seed = rng.seed();
  const float ear = rng.uniform(0.02f, 0.045f);
  SceneObject fur = polygonize(
      [&](vec3 p) {
        vec3 q = frame.to_local(p) / size;
        q.x *= x;
        float d = capsule(q, {-0.12f, -0.02f, 0.02f}, {0.07f, 0.0f, 0.03f}, 0.085f, 0.075f);
        d = blend(d, ellipsoid(q, {0.15f, 0.09f, 0.05f}, {0.062f, 0.058f, 0.06f}), 0.04f);
        d = blend(d, capsule(q, {0.16f, 0.08f, 0.09f}, {0.175f, 0.07f, 0.14f}, 0.032f, 0.024f), 0.02f);
        d = blend(d, capsule(q, {0.11f, 0.13f, 0.04f}, {0.095f, 0.14f + ear, 0.04f}, 0.018f, 0.008f), 0.01f);
        d = blend(d, capsule(q, {0.19f, 0.13f, 0.04f}, {0.21f, 0.14f + ear, 0.04f}, 0.018f, 0.008f), 0.01f);
        d = blend(d, capsule(q, {0.05f, -0.05f, 0.05f}, {0.07f, -0.16f, 0.07f}, 0.028f, 0.02f), 0.03f);
        d = blend(d, capsule(q, {-0.14f, -0.06f, 0.03f}, {-0.13f, -0.17f, 0.05f}, 0.032f, 0.02f), 0.03f);
        return size * (d + 0.012f * (noise(seed, q * 60.0f) + 0.5f * noise(seed + 1, q * 140.0f) - 0.75f));
      },
      frame.origin - 0.36f * size, frame.origin + 0.36f * size, std::max(0.8f * hold.figure.body_cell_m, 0.008f));
  for (std::size_t i = 0; i < fur.positions.size(); ++i) fur.rest[i] = frame.to_local(fur.positions[i]);
  hold.material.kind = rng.chance(0.5f) ? Material::Kind::camouflage : Material::Kind::heather;
  hold.material.scale_m = 0.12f;
  hold.material.a = hair_color(rng, false), hold.material.b = hair_color(rng, false), hold.material.c = vec3(0.6f);
  hold.material.gloss = 0;
  add_object(hold.scene, hold.figure, std::move(fur), hold.material);
}

/// Up to three joined random shapes: toys, tools, instruments, food, clothes, baskets (domain randomization).
void add_generic_thing(Holding& hold, RandomStream& rng) {
  const float scale = hold.figure.body.stature_m / 1.7f;
  const float size_m = scale * (hold.figure.pose.both_hands ? rng.uniform(0.08f, 0.3f) : rng.uniform(0.04f, 0.14f));
  const int parts = 1 + rng.below(3);
  vec3 at = hold.grip;
  for (int i = 0; i < parts; ++i) {
    mat3 axes = axes_along(rng.uniform3(-1, 1) + vec3(0, 0.1f, 0), hold.forward);
    vec3 half = 0.75f * size_m * rng.uniform3(0.15f, 1);
    if (i == 0 && hold.figure.pose.both_hands) {  // from one hand to the other
      const vec3 between = hold.figure.skeleton.hand[1].origin - hold.figure.skeleton.hand[0].origin;
      axes = axes_along(between, hold.forward);
      half.y = 0.5f * glm::length(between) + 0.01f;
    }
    SceneObject part;
    Material own = rng.chance(0.5f) ? cloth_material(rng) : wall_material(rng);
    if (rng.chance(0.3f)) own.kind = Material::Kind::plain;
    switch (rng.below(3)) {
      case 0:
        if (i == 0)
          at += axes * (0.9f * half * vec3(1, 0, 1) * rng.uniform3(-1, 1));  // held by its sides, below, behind
        add_box(part, at, axes, half);
        break;
      case 1:
        add_ellipsoid(part, at, half, axes, 10);
        own.scale_m /= half.y;  // rest positions of an ellipsoid have radius 1
        break;
      default: {
        half.x = half.z = std::min(half.x, half.z);
        const vec3 low = at - half.y * axes[1], high = at + half.y * axes[1];
        add_tube(part, {low, low, at, high, high}, {0, half.x, rng.uniform(1, 2) * half.x, half.x, 0}, 10);
      }
    }
    add_object(hold.scene, hold.figure, std::move(part), own);
    at += axes * (half * vec3(0.3f, 0.8f, 0.3f) * rng.uniform3(-1, 1));  // the next begins inside this one
  }
}

}  // namespace dualpixel::scenes
