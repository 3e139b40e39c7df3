#include "scenes/people/held/things.h"

#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {

Material glossy_material(RandomStream& rng, float gloss) {
  Material material;
  material.a = random_color(rng);
  material.b = random_color(rng);
  material.c = random_color(rng);
  material.seed = rng.seed();
  material.gloss = gloss;
  material.gloss_power = 50;
  return material;
}

void add_phone_or_tablet(Holding& hold, RandomStream& rng) {
  const bool small = hold.figure.pose.held == Held::phone;
  const vec3 half = small ? vec3(0.037f, 0.075f, 0.0045f) : vec3(0.09f, 0.125f, 0.004f);
  const bool at_ear = !hold.figure.pose.both_hands && hold.grip.y > hold.figure.skeleton.head.origin.y - 0.12f;
  const mat3 axes = at_ear ? axes_along(hold.hand().axes[1], hold.hand().axes[2])
                           : axes_along(glm::normalize(kUp - 0.5f * hold.forward), -hold.forward);
  hold.material.a = rng.chance(0.6f) ? vec3(0.015f) : hold.material.a;
  hold.material.gloss = 0.6f;
  add_box(hold.object, at_ear ? hold.hand().to_world({0, 0.03f, 0.03f}) : hold.grip, axes, half);
}

void add_cup(Holding& hold, RandomStream& rng) {
  const float r = rng.uniform(0.032f, 0.044f), tall = rng.uniform(0.08f, 0.14f);
  const vec3 base = hold.grip - kUp * (0.45f * tall);
  add_tube(hold.object, {base, base, base + kUp * tall, base + kUp * tall}, {0, r * 0.8f, r, 0}, 14);
  hold.material.kind = rng.chance(0.4f) ? Material::Kind::stripes_across : Material::Kind::plain;
}

void add_bottle(Holding& hold, RandomStream& rng) {
  const float r = rng.uniform(0.028f, 0.038f), tall = rng.uniform(0.18f, 0.26f);
  const vec3 base = hold.grip - kUp * (0.4f * tall);
  add_tube(hold.object,
           {base, base, base + kUp * (0.68f * tall), base + kUp * (0.8f * tall), base + kUp * tall, base + kUp * tall},
           {0, r, r, 0.4f * r, 0.4f * r, 0}, 12);
  hold.material.kind = rng.chance(0.6f) ? Material::Kind::stripes_across : Material::Kind::plain;
  hold.material.scale_m = 0.12f;
  hold.material.gloss = 0.6f;
}

void add_book(Holding& hold, RandomStream& rng) {
  const bool open = rng.chance(0.5f);
  const mat3 axes = axes_along(glm::normalize(kUp - 0.9f * hold.forward), -hold.forward);
  hold.material.kind = rng.chance(0.5f) ? Material::Kind::collage : Material::Kind::plain;
  hold.material.scale_m = rng.uniform(0.05f, 0.15f);
  hold.material.gloss = 0.1f;
  if (open)
    hold.material.a = vec3(0.7f, 0.68f, 0.6f), hold.material.b = vec3(0.3f),
    hold.material.kind = Material::Kind::stripes_across, hold.material.scale_m = 0.008f;
  add_box(hold.object, hold.grip + 0.05f * kUp, axes,
          {open ? rng.uniform(0.12f, 0.17f) : rng.uniform(0.065f, 0.1f), rng.uniform(0.09f, 0.14f), 0.011f});
}

void add_ball(Holding& hold, RandomStream& rng) {
  add_ellipsoid(hold.object, hold.grip + 0.06f * hold.forward, vec3(rng.uniform(0.08f, 0.13f)), mat3(1), 14);
  hold.material.kind = Material::Kind::checks;
  hold.material.scale_m = 0.9f;
}

void add_microphone(Holding& hold, RandomStream&) {
  const vec3 along = glm::normalize(kUp * 0.8f - hold.forward * 0.4f + hold.hand().axes[1] * 0.3f);
  add_tube(hold.object,
           {hold.grip - 0.08f * along, hold.grip - 0.08f * along, hold.grip + 0.1f * along, hold.grip + 0.12f * along},
           {0, 0.011f, 0.014f, 0.02f}, 8);
  add_ellipsoid(hold.object, hold.grip + 0.135f * along, vec3(0.025f), mat3(1), 8);
  hold.material.a = vec3(0.05f);
}

void add_umbrella(Holding& hold, RandomStream& rng) {
  const vec3 top = hold.grip + vec3(0, 0.75f, 0);
  const float r = rng.uniform(0.42f, 0.6f);
  add_tube(hold.object, {hold.grip - 0.1f * kUp, top}, {0.008f, 0.006f}, 6);
  add_tube(hold.object, {top + 0.03f * kUp, top, top - 0.06f * kUp, top - 0.17f * kUp, top - 0.3f * kUp},
           {0, 0.25f * r, 0.6f * r, 0.88f * r, r}, 16);
  hold.material.kind = rng.chance(0.4f) ? Material::Kind::stripes_along : Material::Kind::plain;
  hold.material.scale_m = 0.4f;
}

void add_wine_glass(Holding& hold, RandomStream& rng) {
  const float r = rng.uniform(0.026f, 0.04f), tall = rng.uniform(0.16f, 0.22f);
  const vec3 base = hold.grip - kUp * (0.3f * tall);
  add_tube(hold.object,
           {base, base, base + kUp * 0.005f, base + kUp * (0.45f * tall), base + kUp * (0.65f * tall),
            base + kUp * tall, base + kUp * tall},
           {0, 0.9f * r, 0.004f, 0.004f, r, 0.85f * r, 0}, 14);
  hold.material.gloss = 0.7f;
}

void add_parcel(Holding& hold, RandomStream& rng) {
  const vec3 half(rng.uniform(0.12f, 0.18f), rng.uniform(0.06f, 0.13f), rng.uniform(0.08f, 0.14f));
  add_box(hold.object, hold.grip + vec3(0, half.y, 0) + 0.3f * half.z * hold.forward, axes_along(kUp, hold.forward),
          half);
  hold.material.kind = rng.chance(0.5f) ? Material::Kind::print : Material::Kind::plain;
  hold.material.scale_m = rng.uniform(0.05f, 0.1f);
  hold.material.gloss = 0.05f;
}

}  // namespace dualpixel::scenes
