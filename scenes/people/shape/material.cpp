#include "scenes/people/shape/material.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "scenes/math.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

using Kind = Material::Kind;

constexpr Kind kCloth[] = {
    Kind::plain,  Kind::plain,  Kind::plain,  Kind::heather, Kind::heather, Kind::stripes_across, Kind::stripes_along,
    Kind::checks, Kind::dots,   Kind::floral, Kind::knit,    Kind::denim,   Kind::print,          Kind::medley,
    Kind::medley, Kind::medley, Kind::medley, Kind::medley,  Kind::argyle,  Kind::zigzag,         Kind::camouflage};
constexpr Kind kWall[] = {Kind::rough,  Kind::rough,   Kind::plain,  Kind::bricks,        Kind::planks,
                          Kind::tiles,  Kind::collage, Kind::floral, Kind::stripes_along, Kind::facade,
                          Kind::books,  Kind::foliage, Kind::medley, Kind::medley,        Kind::medley,
                          Kind::medley, Kind::medley,  Kind::stones, Kind::herringbone,   Kind::graffiti};

}  // namespace

vec3 random_color(RandomStream& rng) {
  const auto from_hue = [&](float hue, float saturation, float value) {
    vec3 rgb;
    for (int c = 0; c < 3; ++c)
      rgb[c] = std::clamp(std::abs(fraction(hue + static_cast<float>(3 - c) / 3) * 6 - 3) - 1, 0.0f, 1.0f);
    return value * glm::mix(vec3(1), rgb, saturation);
  };
  switch (rng.below(6)) {
    case 0:
      return vec3(rng.uniform(0.012f, 0.07f)) * (1.0f + 0.15f * rng.uniform3(-1, 1));  // near black
    case 1:
      return vec3(rng.uniform(0.5f, 0.88f)) * (1.0f + 0.08f * rng.uniform3(-1, 1));  // near white
    case 2:
      return vec3(rng.uniform(0.08f, 0.5f)) * (1.0f + 0.15f * rng.uniform3(-1, 1));  // gray, beige, khaki
    case 3:
      return from_hue(rng.uniform(), rng.uniform(0.3f, 0.7f), rng.uniform(0.04f, 0.2f));  // navy, wine, bottle green
    case 4:
      return from_hue(rng.uniform(), rng.uniform(0.2f, 0.6f), rng.uniform(0.25f, 0.75f));  // pastel
    default:
      return from_hue(rng.uniform(), rng.uniform(0.65f, 0.95f), rng.uniform(0.15f, 0.7f));  // bright
  }
}

vec3 skin_color(RandomStream& rng) {
  constexpr int kMeans = 6;
  const vec3 mean[kMeans] = {{0.055f, 0.028f, 0.018f}, {0.13f, 0.065f, 0.04f},  {0.25f, 0.135f, 0.085f},
                             {0.38f, 0.22f, 0.145f},   {0.53f, 0.335f, 0.245f}, {0.66f, 0.45f, 0.36f}};
  // the middle and pale half of the scale somewhat more often; none is rare
  const float tone = (kMeans - 1.001f) * std::pow(rng.uniform(), 0.75f);
  const int i = static_cast<int>(tone);
  const vec3 color = glm::mix(mean[i], mean[i + 1], tone - static_cast<float>(i));
  const float red = 0.06f * rng.normal(), yellow = 0.06f * rng.normal();
  return color * vec3(1 + 0.5f * red, 1 - red, 1 - red - yellow) * (1 + 0.08f * rng.normal());
}

vec3 hair_color(RandomStream& rng, bool old) {
  const int kind = old ? 4 + rng.below(2) : rng.below(18);
  const float t = rng.uniform();
  if (kind <= 2 || kind >= 14) return glm::mix(vec3(0.006f, 0.005f, 0.005f), vec3(0.03f, 0.02f, 0.014f), t);
  if (kind == 3 || (kind >= 8 && kind < 14))
    return glm::mix(vec3(0.025f, 0.014f, 0.008f), vec3(0.16f, 0.085f, 0.045f), t);
  if (kind == 4) return vec3(0.12f + 0.3f * t) * vec3(1, 0.98f, 0.95f);
  if (kind == 5) return vec3(0.4f + 0.35f * t);
  if (kind == 6) return glm::mix(vec3(0.28f, 0.18f, 0.09f), vec3(0.6f, 0.45f, 0.26f), t);
  if (rng.chance(0.25f)) return random_color(rng);
  return glm::mix(vec3(0.14f, 0.035f, 0.012f), vec3(0.4f, 0.14f, 0.05f), t);
}

MaterialPool cloth_pool() { return {kCloth, static_cast<int>(std::size(kCloth)), 3}; }
MaterialPool wall_pool() { return {kWall, static_cast<int>(std::size(kWall)), 3}; }

Material cloth_material(RandomStream& rng) {
  Material material;
  const MaterialPool pool = cloth_pool();
  // most cloth is plain: held-out sets have plain cloth, too, in colors of their own
  material.kind = rng.domain_randomized() && rng.chance(0.6f) ? Kind::medley
                  : rng.chance(0.4f)                          ? Kind::heather
                                                              : pool.kinds[rng.choose(pool.count, pool.reserved)];
  material.a = random_color(rng);
  material.b = random_color(rng);
  material.c = random_color(rng);
  material.seed = rng.seed();
  material.scale_m = rng.chance(0.5f) ? rng.uniform(0.015f, 0.05f) : rng.uniform(0.04f, 0.14f);
  if (material.kind == Kind::denim) {
    material.a = vec3(0.02f, 0.035f, 0.07f) * rng.uniform(0.5f, 2);
    material.b = vec3(0.15f, 0.22f, 0.33f) * rng.uniform(0.5f, 1.5f);
  }
  if (material.kind == Kind::print) material.scale_m = rng.uniform(0.04f, 0.09f);
  material.gloss = rng.chance(0.15f) ? rng.uniform(0.1f, 0.5f) : 0;
  material.gloss_power = rng.uniform(6, 30);
  return material;
}

Material wall_material(RandomStream& rng) {
  Material material;
  const MaterialPool pool = wall_pool();
  material.kind = rng.domain_randomized() && rng.chance(0.6f) ? Kind::medley
                  : rng.chance(0.35f)                         ? Kind::rough
                                                              : pool.kinds[rng.choose(pool.count, pool.reserved)];
  material.a = random_color(rng);
  material.b = rng.chance(0.6f) ? material.a * rng.uniform(0.4f, 0.9f) : random_color(rng);
  material.c = rng.chance(0.5f) ? glm::mix(material.a, random_color(rng), 0.4f) : random_color(rng);
  material.seed = rng.seed();
  material.scale_m = rng.uniform(0.15f, 0.6f);
  switch (material.kind) {
    case Kind::bricks:
      material.scale_m = rng.uniform(0.18f, 0.32f);
      if (rng.chance(0.6f)) material.a = vec3(0.42f, 0.16f, 0.1f) * rng.uniform(0.5f, 1.4f);
      break;
    case Kind::planks:
      material.scale_m = rng.uniform(0.07f, 0.25f);
      if (rng.chance(0.7f))
        material.a = vec3(0.36f, 0.2f, 0.1f) * rng.uniform(0.4f, 1.6f), material.c = 0.5f * material.a;
      break;
    case Kind::foliage:
      material.scale_m = rng.uniform(0.05f, 0.25f);
      material.a = vec3(rng.uniform(0.05f, 0.25f), rng.uniform(0.15f, 0.4f), rng.uniform(0.02f, 0.12f));
      material.c = material.a * vec3(rng.uniform(0.7f, 2), rng.uniform(0.7f, 1.3f), rng.uniform(0.5f, 1.2f));
      break;
    case Kind::facade:
      material.scale_m = rng.uniform(1.2f, 3);
      break;
    case Kind::books:
      material.scale_m = rng.uniform(0.03f, 0.06f);
      break;
    default:
      break;
  }
  return material;
}

Material plain_material(glm::vec3 color, float gloss) {
  Material material;
  material.a = color;
  material.gloss = gloss;
  return material;
}

}  // namespace dualpixel::scenes
