#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {
namespace {

constexpr const char* kHeldNames[] = {"nothing",    "phone",    "cup",   "bottle", "book",
                                      "bag",        "bouquet",  "ball",  "animal", "tablet",
                                      "microphone", "umbrella", "thing", "glass",  "parcel"};
static_assert(std::size(kHeldNames) == static_cast<std::size_t>(Held::parcel) + 1);

Material glossy(RandomStream& rng, float gloss) {
  Material material;
  material.a = random_color(rng);
  material.b = random_color(rng);
  material.c = random_color(rng);
  material.seed = rng.seed();
  material.gloss = gloss;
  material.gloss_power = 50;
  return material;
}

}  // namespace

void add_held_thing(SceneModel& scene, Figure& figure, RandomStream rng) {
  const Held held = figure.pose.held;
  if (held == Held::nothing) return;
  figure.tags.push_back(std::string("held:") + kHeldNames[static_cast<int>(held)]);
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m;
  const Frame& hand = k.hand[figure.pose.held_side];
  const vec3 up(0, 1, 0);
  // in the palm, or between both hands
  vec3 grip = hand.to_world({0, 0.02f, 0.035f});
  if (figure.pose.both_hands)
    grip = 0.5f * (k.hand[0].to_world({0, 0.03f, 0.03f}) + k.hand[1].to_world({0, 0.03f, 0.03f}));
  const vec3 forward = k.chest.axes[2];
  SceneObject object;
  Material material = glossy(rng, 0.2f);
  switch (held) {
    case Held::phone:
    case Held::tablet: {
      const bool small = held == Held::phone;
      const vec3 half = small ? vec3(0.037f, 0.075f, 0.0045f) : vec3(0.09f, 0.125f, 0.004f);
      const bool at_ear = !figure.pose.both_hands && grip.y > k.head.origin.y - 0.12f;
      const mat3 axes =
          at_ear ? axes_along(hand.axes[1], hand.axes[2]) : axes_along(glm::normalize(up - 0.5f * forward), -forward);
      material.a = rng.chance(0.6f) ? vec3(0.015f) : material.a;
      material.gloss = 0.6f;
      add_box(object, at_ear ? hand.to_world({0, 0.03f, 0.03f}) : grip, axes, half);
      break;
    }
    case Held::cup: {
      const float r = rng.uniform(0.032f, 0.044f), tall = rng.uniform(0.08f, 0.14f);
      const vec3 base = grip - up * (0.45f * tall);
      add_tube(object, {base, base, base + up * tall, base + up * tall}, {0, r * 0.8f, r, 0}, 14);
      material.kind = rng.chance(0.4f) ? Material::Kind::stripes_across : Material::Kind::plain;
      break;
    }
    case Held::bottle: {
      const float r = rng.uniform(0.028f, 0.038f), tall = rng.uniform(0.18f, 0.26f);
      const vec3 base = grip - up * (0.4f * tall);
      add_tube(object,
               {base, base, base + up * (0.68f * tall), base + up * (0.8f * tall), base + up * tall, base + up * tall},
               {0, r, r, 0.4f * r, 0.4f * r, 0}, 12);
      material.kind = rng.chance(0.6f) ? Material::Kind::stripes_across : Material::Kind::plain;
      material.scale_m = 0.12f;
      material.gloss = 0.6f;
      break;
    }
    case Held::book: {
      const bool open = rng.chance(0.5f);
      const mat3 axes = axes_along(glm::normalize(up - 0.9f * forward), -forward);
      material.kind = rng.chance(0.5f) ? Material::Kind::collage : Material::Kind::plain;
      material.scale_m = rng.uniform(0.05f, 0.15f);
      material.gloss = 0.1f;
      if (open)
        material.a = vec3(0.7f, 0.68f, 0.6f), material.b = vec3(0.3f), material.kind = Material::Kind::stripes_across,
        material.scale_m = 0.008f;
      add_box(object, grip + 0.05f * up, axes,
              {open ? rng.uniform(0.12f, 0.17f) : rng.uniform(0.065f, 0.1f), rng.uniform(0.09f, 0.14f), 0.011f});
      break;
    }
    case Held::bag: {
      // over a shoulder, across the chest or down at the side
      const int side = figure.pose.held_side;
      const bool across = rng.chance(0.45f);
      const float x = side == 0 ? 1.0f : -1.0f;
      const vec3 shoulder =
          glm::mix(k.shoulder[side], k.neck_base, 0.3f) + up * (0.05f * h * (1 + 0.1f * figure.body.girth));
      const vec3 low = across ? k.pelvis.to_world({-x * 0.13f * h, 0.02f * h, 0.05f * h})
                              : k.pelvis.to_world({x * 0.15f * h, 0.06f * h, 0.02f * h});
      std::vector<vec3> path;
      for (int i = 0; i <= 8; ++i) {
        const float t = static_cast<float>(i) / 8;
        vec3 p = glm::mix(shoulder, low, t) +
                 forward * ((across ? 0.075f : 0.05f) * h * std::sqrt(std::max(std::sin(3.1f * t), 0.0f)));
        for (int step = 0; step < 3; ++step) {  // on the body, not in it
          const float room = 0.03f - figure.bare(p);
          if (room > 0) p += forward * room;
        }
        path.push_back(p);
      }
      add_tube(object, path, std::vector<float>(path.size(), rng.uniform(0.008f, 0.02f)), 6);
      const vec3 half(rng.uniform(0.04f, 0.07f), rng.uniform(0.08f, 0.16f), rng.uniform(0.1f, 0.17f));
      add_box(object, low - up * half.y, k.pelvis.axes, half);
      material.kind = rng.chance(0.3f) ? Material::Kind::checks : Material::Kind::plain;
      material.gloss = 0.15f;
      break;
    }
    case Held::bouquet: {
      Material leaves = glossy(rng, 0.1f);
      leaves.kind = Material::Kind::foliage;
      leaves.scale_m = 0.02f;
      leaves.a = {0.1f, 0.22f, 0.06f};
      leaves.c = {0.2f, 0.35f, 0.1f};
      SceneObject stems;
      for (int i = 0; i < 45; ++i) {
        const vec3 out = glm::normalize(rng.uniform3(-1, 1) + vec3(0, 1.3f, 0));
        const vec3 at = grip + out * rng.uniform(0.1f, 0.22f);
        add_ellipsoid(i % 3 == 0 ? stems : object, at, vec3(1, 0.6f, 1) * rng.uniform(0.01f, 0.03f),
                      axes_along(out, forward), 5);
      }
      add_tube(stems, {grip - 0.12f * up, grip, grip + 0.1f * up}, {0.012f, 0.02f, 0.06f}, 8);
      add_object(scene, figure, std::move(stems), leaves);
      material.kind = Material::Kind::heather;
      break;
    }
    case Held::ball:
      add_ellipsoid(object, grip + 0.06f * forward, vec3(rng.uniform(0.08f, 0.13f)), mat3(1), 14);
      material.kind = Material::Kind::checks;
      material.scale_m = 0.9f;
      break;
    case Held::animal: {
      // dog or cat sized: body, head with muzzle and ears, legs, all fur
      const float size = rng.uniform(0.75f, 1.3f), x = figure.pose.held_side == 0 ? 1.0f : -1.0f;
      const Frame frame{grip + 0.05f * forward, k.chest.axes};
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
          frame.origin - 0.36f * size, frame.origin + 0.36f * size, std::max(0.8f * figure.body_cell_m, 0.008f));
      for (std::size_t i = 0; i < fur.positions.size(); ++i) fur.rest[i] = frame.to_local(fur.positions[i]);
      material.kind = rng.chance(0.5f) ? Material::Kind::camouflage : Material::Kind::heather;
      material.scale_m = 0.12f;
      material.a = hair_color(rng, false), material.b = hair_color(rng, false), material.c = vec3(0.6f);
      material.gloss = 0;
      add_object(scene, figure, std::move(fur), material);
      return;
    }
    case Held::microphone: {
      const vec3 along = glm::normalize(up * 0.8f - forward * 0.4f + hand.axes[1] * 0.3f);
      add_tube(object, {grip - 0.08f * along, grip - 0.08f * along, grip + 0.1f * along, grip + 0.12f * along},
               {0, 0.011f, 0.014f, 0.02f}, 8);
      add_ellipsoid(object, grip + 0.135f * along, vec3(0.025f), mat3(1), 8);
      material.a = vec3(0.05f);
      break;
    }
    case Held::umbrella: {
      const vec3 top = grip + vec3(0, 0.75f, 0);
      const float r = rng.uniform(0.42f, 0.6f);
      add_tube(object, {grip - 0.1f * up, top}, {0.008f, 0.006f}, 6);
      add_tube(object, {top + 0.03f * up, top, top - 0.06f * up, top - 0.17f * up, top - 0.3f * up},
               {0, 0.25f * r, 0.6f * r, 0.88f * r, r}, 16);
      material.kind = rng.chance(0.4f) ? Material::Kind::stripes_along : Material::Kind::plain;
      material.scale_m = 0.4f;
      break;
    }
    case Held::thing: {  // a few shapes joined: stands for toys, tools, instruments, food, clothes, baskets, ...
      const float scale = h / 1.7f;
      const float size_m = scale * (figure.pose.both_hands ? rng.uniform(0.08f, 0.3f) : rng.uniform(0.04f, 0.14f));
      const int parts = 1 + rng.below(3);
      vec3 at = grip;
      for (int i = 0; i < parts; ++i) {
        mat3 axes = axes_along(rng.uniform3(-1, 1) + vec3(0, 0.1f, 0), forward);
        vec3 half = 0.75f * size_m * rng.uniform3(0.15f, 1);
        if (i == 0 && figure.pose.both_hands) {  // from one hand to the other
          const vec3 between = k.hand[1].origin - k.hand[0].origin;
          axes = axes_along(between, forward);
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
            own.scale_m /= half.y;  // a ball's rest places are of radius 1
            break;
          default: {
            half.x = half.z = std::min(half.x, half.z);
            const vec3 low = at - half.y * axes[1], high = at + half.y * axes[1];
            add_tube(part, {low, low, at, high, high}, {0, half.x, rng.uniform(1, 2) * half.x, half.x, 0}, 10);
          }
        }
        add_object(scene, figure, std::move(part), own);
        at += axes * (half * vec3(0.3f, 0.8f, 0.3f) * rng.uniform3(-1, 1));  // the next begins inside this one
      }
      return;
    }
    case Held::glass: {  // with a stem
      const float r = rng.uniform(0.026f, 0.04f), tall = rng.uniform(0.16f, 0.22f);
      const vec3 base = grip - up * (0.3f * tall);
      add_tube(object,
               {base, base, base + up * 0.005f, base + up * (0.45f * tall), base + up * (0.65f * tall),
                base + up * tall, base + up * tall},
               {0, 0.9f * r, 0.004f, 0.004f, r, 0.85f * r, 0}, 14);
      material.gloss = 0.7f;
      break;
    }
    case Held::parcel: {
      const vec3 half(rng.uniform(0.12f, 0.18f), rng.uniform(0.06f, 0.13f), rng.uniform(0.08f, 0.14f));
      add_box(object, grip + vec3(0, half.y, 0) + 0.3f * half.z * forward, axes_along(up, forward), half);
      material.kind = rng.chance(0.5f) ? Material::Kind::print : Material::Kind::plain;
      material.scale_m = rng.uniform(0.05f, 0.1f);
      material.gloss = 0.05f;
      break;
    }
    case Held::nothing:
      break;
  }
  add_object(scene, figure, std::move(object), material);
}

}  // namespace dualpixel::scenes
