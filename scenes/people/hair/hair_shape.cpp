#include "scenes/people/hair/hair_shape.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

constexpr const char* kStyleNames[] = {"bald", "cropped", "short", "parted", "curly",    "afro",
                                       "bob",  "long",    "wavy",  "bun",    "ponytail", "braids"};
constexpr int kStyles = 12;
static_assert(std::size(kStyleNames) == kStyles && static_cast<int>(HairStyle::braids) == kStyles - 1);
constexpr int kShortStyles = 6;

/// What the style changes.
void apply_style(Hair& hair, RandomStream& rng) {
  switch (hair.style) {
    case HairStyle::bald:
      break;
    case HairStyle::cropped:
      hair.shape.thick_m = rng.uniform(0.002f, 0.005f);
      hair.shape.rough_m = 0.001f;
      hair.shape.hairline_m = rng.uniform(0.072f, 0.1f);
      hair.strands = 150, hair.strand_m = 0.008f, hair.lift = 1;
      break;
    case HairStyle::short_cap:
      hair.shape.thick_m = rng.uniform(0.007f, 0.016f);
      hair.shape.top_m = rng.uniform(0, 0.03f);
      hair.lift = rng.uniform(0.2f, 1);
      break;
    case HairStyle::parted:
      hair.shape.part_x = rng.sign() * rng.uniform(0.025f, 0.045f);
      hair.shape.top_m = rng.uniform(0.01f, 0.035f);
      break;
    case HairStyle::curly:
      hair.shape.thick_m = rng.uniform(0.015f, 0.035f);
      hair.shape.top_m = rng.uniform(0, 0.03f);
      hair.shape.rough_m = rng.uniform(0.012f, 0.022f);
      hair.shape.rough_per_m = rng.uniform(50, 90);
      hair.strands = 900, hair.lift = 0.9f, hair.curl = 0.8f, hair.strand_m = 0.025f;
      break;
    case HairStyle::afro:
      hair.shape.thick_m = rng.uniform(0.035f, 0.09f);
      hair.shape.rough_m = 0.014f;
      hair.shape.nape_m = -0.09f;
      hair.strands = 1200, hair.lift = 2, hair.curl = 0.9f, hair.strand_m = 0.02f;
      break;
    case HairStyle::bob:
      hair.shape.fall_m = rng.uniform(-0.04f, 0.03f) + 0.06f;
      hair.shape.fall_front = rng.uniform(0.3f, 0.8f);
      hair.shape.ear_cut = 0;
      hair.shape.nape_m = -0.15f;
      hair.shape.fall_thick = rng.uniform(0.025f, 0.05f);
      break;
    case HairStyle::long_straight:
    case HairStyle::long_wavy:
      hair.shape.fall_m = rng.uniform(0.08f, 0.32f);
      hair.shape.fall_front = rng.uniform(0, 1);
      hair.shape.ear_cut = rng.chance(0.4f) ? 1.0f : 0.0f;
      hair.shape.nape_m = -0.2f;
      hair.shape.fall_thick = rng.uniform(0.022f, 0.05f);
      if (hair.style == HairStyle::long_wavy)
        hair.shape.rough_m = rng.uniform(0.014f, 0.026f), hair.shape.rough_per_m = rng.uniform(30, 60),
        hair.curl = 0.5f;
      hair.strands = 900, hair.strand_m = 0.06f;
      break;
    case HairStyle::bun:
      hair.shape.bun = true;
      hair.shape.bun_at = rng.chance(0.5f) ? vec3(0, 0.155f, -0.05f) : vec3(0, 0.06f, -0.135f);
      hair.shape.bun_m = rng.uniform(0.028f, 0.05f);
      break;
    case HairStyle::ponytail:
      hair.shape.tail = true;
      hair.shape.tail_m = rng.uniform(0.12f, 0.35f);
      break;
    case HairStyle::braids:
      hair.shape.braids = true;
      hair.shape.fall_thick = rng.uniform(0.02f, 0.05f);
      break;
  }
}

}  // namespace

float HairShape::operator()(vec3 p) const {
  const vec3 s(std::abs(p.x), p.y, p.z);
  float d = ellipsoid(p, {0, 0.035f + 0.4f * top_m, -0.014f}, vec3(0.079f, 0.102f + 0.6f * top_m, 0.098f) + thick_m);
  d = std::max(d, nape_m - 0.15f * p.z - p.y);
  // the face: everything in front of a slanted sheet below the hairline
  const float side = p.x - part_x;
  const float line = hairline_m - 2.2f * side * side - 0.004f * std::sin(p.x * 110);
  const float face =
      std::max(p.y - line, 0.022f + 0.25f * std::max(p.y, 0.0f) + 0.1f * ear_cut * std::max(-p.y, 0.0f) - p.z);
  d = carve(d, face, 0.012f);
  if (ear_cut > 0.5f) d = carve(d, ellipsoid(s, {0.09f, -0.012f, 0.006f}, {0.045f, 0.05f, 0.034f}), 0.012f);
  if (fall_m > 0) {
    const float front = -0.035f + 0.075f * fall_front;
    const vec3 temple(0.078f, 0.02f, -0.012f), end(0.085f + 0.012f * fall_front, -0.1f - fall_m, front);
    d = blend(d, capsule(s, temple, end, 0.018f + thick_m, fall_thick), 0.03f);
    d = blend(d, capsule(p, {0, 0.0f, -0.075f}, {0, -0.1f - fall_m, -0.085f}, 0.055f, 0.045f + fall_thick), 0.05f);
  }
  if (fall_m > 0) {  // neck and throat stay uncovered
    d = carve(d, capsule(p, {0, -0.07f, 0.06f}, {0, -0.5f, 0.08f}, 0.062f, 0.05f), 0.02f);
    d = carve(d, capsule(p, {0, -0.1f, 0.0f}, {0, -0.5f, 0.03f}, 0.05f, 0.075f), 0.02f);
  }
  if (bun) d = blend(d, glm::length(p - bun_at) - bun_m, 0.012f);
  if (tail) d = blend(d, capsule(p, {0, 0.07f, -0.115f}, {0.03f, 0.07f - tail_m, -0.15f}, 0.03f, 0.022f), 0.02f);
  if (braids)
    d = blend(d, capsule(s, {0.06f, -0.02f, -0.05f}, {0.095f, -0.12f - fall_thick * 4, 0.02f}, 0.02f, 0.014f), 0.02f);
  const float lumps = noise(seed, p * vec3(rough_per_m, 0.55f * rough_per_m, rough_per_m));
  const float locks = noise(seed + 1, p * rough_per_m * vec3(2.3f, 0.9f, 2.3f));
  return d - rough_m * (lumps + 0.5f * locks - 0.7f);
}

const char* name_of(HairStyle style) { return kStyleNames[static_cast<int>(style)]; }

Hair draw_hair(const Body& body, RandomStream& rng) {
  Hair hair;
  const bool man = body.woman < 0.5f;
  // men wear short hair four times in five, women long hair as often
  const bool is_short = rng.chance(man ? 0.82f : 0.16f);
  int kind = is_short ? rng.below(kShortStyles) : kShortStyles + rng.below(kStyles - kShortStyles);
  if (kind == 0 && (!man || body.child)) kind = 2;
  hair.style = static_cast<HairStyle>(kind);
  hair.shape.seed = rng.seed();
  hair.shape.thick_m = rng.uniform(0.008f, 0.022f);
  hair.shape.hairline_m = rng.uniform(0.066f, 0.092f);
  hair.shape.part_x = rng.uniform(-0.03f, 0.03f);
  hair.shape.rough_m = rng.uniform(0.004f, 0.012f);
  hair.shape.rough_per_m = rng.uniform(35, 80);
  const bool fringe = rng.chance(is_short ? 0.2f : 0.35f);
  if (fringe) hair.shape.hairline_m = rng.uniform(0.036f, 0.055f);
  apply_style(hair, rng);
  return hair;
}

}  // namespace dualpixel::scenes
