#include "scenes/people/shape/patterns.h"

#include <numbers>

namespace dualpixel::scenes {
namespace {

vec3 bricks(const Material& material, vec3 p, bool tiles) {
  const float width = material.scale_m, height = tiles ? material.scale_m : material.scale_m * 0.34f;
  const float row = std::floor(p.y / height);
  const float x = p.x / width + (tiles ? 0 : 0.5f * std::fmod(std::abs(row), 2.0f)), column = std::floor(x);
  const float edge = std::min({x - column, 1 - (x - column), (p.y / height - row) * height / width,
                               (1 - (p.y / height - row)) * height / width});
  const float tone = hash01(material.seed, static_cast<int>(column), static_cast<int>(row));
  const float grain = fractal(material.seed + 2, p * (6 / material.scale_m), 3);
  if (edge < 0.035f) return material.b * (0.7f + 0.6f * grain);
  return glm::mix(material.a, material.c, tone * tone * 0.6f) * (0.6f + 0.5f * tone + 0.5f * (grain - 0.5f));
}

vec3 planks(const Material& material, vec3 p) {
  const float board = std::floor(p.x / material.scale_m);
  const float within = p.x / material.scale_m - board;
  const float tone = hash01(material.seed, static_cast<int>(board));
  const float wave = fractal(material.seed + 1, {p.x * 8, p.y * 0.8f, tone * 9}, 2);
  const float grain = 0.5f + 0.5f * std::sin(2 * std::numbers::pi_v<float> * (p.x * 18 + 5 * wave));
  const vec3 wood = glm::mix(material.a, material.c, 0.35f * grain + 0.35f * wave) * (0.7f + 0.5f * tone);
  return within < 0.03f ? wood * 0.3f : wood;
}

/// Windows in rows, some lit, some with a curtain, each a little different.
vec3 facade(const Material& material, vec3 p) {
  const float u = p.x / material.scale_m, w = p.y / (material.scale_m * 1.25f);
  const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(w));
  const float x = saw(u), y = saw(w);
  const float own = hash01(material.seed, column, row);
  const bool window = x > 0.22f && x < 0.78f && y > 0.2f && y < 0.82f;
  if (!window) return material.a * (0.75f + 0.5f * fractal(material.seed, p * 1.5f, 3)) * (y < 0.05f ? 0.7f : 1.0f);
  if (x < 0.26f || x > 0.74f || y < 0.23f || y > 0.79f || std::abs(x - 0.5f) < 0.02f) return material.c;
  if (own > 0.8f) return glm::mix(material.b, vec3(0.8f, 0.7f, 0.5f), 0.7f);
  return glm::mix(material.b, vec3(0.25f, 0.3f, 0.36f), y * own) * (0.4f + 0.6f * own);
}

vec3 books(const Material& material, vec3 p) {
  const float shelf = material.scale_m * 6;  // height of a shelf
  const float row = std::floor(p.y / shelf), y = p.y / shelf - row;
  if (y < 0.1f) return material.a;
  const float warped =
      p.x / material.scale_m + 0.9f * noise(material.seed, {p.x / material.scale_m * 0.5f, row * 7, 0});
  const int book = static_cast<int>(std::floor(warped)), shelf_id = static_cast<int>(row);
  const float height = 0.6f + 0.35f * hash01(material.seed, book, shelf_id);
  if (y > height || hash01(material.seed, book / 7, shelf_id, 5) > 0.85f) return material.b * 0.3f;
  const vec3 cover(hash01(material.seed, book, shelf_id, 1), hash01(material.seed, book, shelf_id, 2),
                   hash01(material.seed, book, shelf_id, 3));
  const bool title = std::abs(y - 0.4f) < 0.06f;
  const vec3 muted = glm::mix(cover * cover, vec3(0.3f, 0.25f, 0.2f), hash01(material.seed, book, shelf_id, 6));
  return muted * (saw(warped) < 0.08f ? 0.3f : 1.0f) + (title ? vec3(0.25f) : vec3(0));
}

/// Patches, discs and slopes of color, as of a picture, a poster or many things out of focus.
vec3 collage(const Material& material, vec3 p) {
  vec3 color = glm::mix(material.a, material.b, fractal(material.seed, p / material.scale_m, 2));
  for (int i = 0; i < 3; ++i) {
    const vec2 q =
        vec2(p.x, p.y) / material.scale_m * (0.7f + 0.6f * static_cast<float>(i)) + 13.7f * static_cast<float>(i);
    float own = 0;
    const float d = cells(material.seed + 11 * i, q, own);
    const float radius = 0.1f + 0.35f * saw(own * 7);
    const vec3 patch(saw(own * 13), saw(own * 29), saw(own * 53));
    color = glm::mix(color, glm::mix(patch * patch, material.c, 0.35f),
                     smooth_step(radius - d, 0.03f + 0.15f * saw(own * 3)));
  }
  return color;
}

vec3 foliage(const Material& material, vec3 p) {
  float own = 0, other = 0;
  const vec2 q = vec2(p.x + 0.4f * p.z, p.y) / material.scale_m;
  const float wobble = 2 * noise(material.seed + 5, p / material.scale_m * 0.7f);
  const float d = cells(material.seed, q + wobble, own), e = cells(material.seed + 3, q * 0.45f, other);
  const float light = smooth_step(fractal(material.seed + 8, p / material.scale_m * 0.22f, 3) - 0.3f, 0.5f);
  const vec3 leaf = glm::mix(material.a, material.c, 0.5f * own + 0.5f * other);
  return leaf * (0.15f + 1.1f * light * (0.35f + 0.65f * own)) * (1 - 0.55f * smooth_step(d - 0.35f, 0.4f)) *
         (1 - 0.4f * smooth_step(e - 0.5f, 0.3f));
}

vec3 crowd(const Material& material, vec3 p) {
  const float across = p.x / material.scale_m;
  const int n = static_cast<int>(std::floor(across));
  const float tall = material.scale_m * (2.6f + 0.9f * hash01(material.seed, n)), x = saw(across) - 0.5f;
  const float y = p.y;
  const vec3 cloth(hash01(material.seed, n, 1), hash01(material.seed, n, 2), hash01(material.seed, n, 3));
  if (std::abs(x) < 0.38f * smooth_step(tall - y, 0.5f * material.scale_m)) return cloth * cloth * 0.7f;
  if (glm::length(vec2(x * material.scale_m, y - tall - 0.2f * material.scale_m)) < 0.22f * material.scale_m) {
    return glm::mix(vec3(0.08f, 0.04f, 0.025f), vec3(0.6f, 0.4f, 0.3f), hash01(material.seed, n, 4));
  }
  return glm::mix(material.a, material.b, fractal(material.seed, p, 3));
}

vec3 herringbone(const Material& material, vec3 p) {
  const float u = p.x / material.scale_m, w = p.y / material.scale_m;
  const float slant = static_cast<int>(std::floor(u)) % 2 == 0 ? u : -u;
  const float k = 4 * (w + slant);
  const float tone = hash01(material.seed, static_cast<int>(std::floor(u)), static_cast<int>(std::floor(k)));
  return (saw(k) < 0.1f ? material.b : material.a * (0.6f + 0.7f * tone)) *
         (0.8f + 0.4f * noise(material.seed, p * 40.0f));
}

vec3 graffiti(const Material& material, vec3 p) {
  vec3 color = material.a * (0.7f + 0.6f * fractal(material.seed, p * 4.0f, 3));
  for (int i = 0; i < 3; ++i) {
    const auto seed = material.seed + 17 * static_cast<std::uint32_t>(i);
    const float line = std::abs(fractal(seed, p / material.scale_m * 1.2f, 2) - 0.5f);
    const vec3 paint(hash01(seed, 1), hash01(seed, 2), hash01(seed, 3));
    color = glm::mix(color, paint * paint, smooth_step(0.055f - line, 0.02f));
  }
  return color;
}

}  // namespace

vec3 environment_pattern(const Material& material, vec3 p) {
  using Kind = Material::Kind;
  const float s = material.scale_m;
  switch (material.kind) {
    case Kind::rough:
      return glm::mix(material.a, material.b, 0.7f * fractal(material.seed, p / s, 5, 0.65f));
    case Kind::bricks:
      return bricks(material, p, false);
    case Kind::tiles:
      return bricks(material, p, true);
    case Kind::planks:
      return planks(material, p);
    case Kind::facade:
      return facade(material, p);
    case Kind::books:
      return books(material, p);
    case Kind::collage:
      return collage(material, p);
    case Kind::foliage:
      return foliage(material, p);
    case Kind::grass:
      return glm::mix(material.a, material.c, fractal(material.seed, {p.x * 40, p.y * 12, p.z * 40}, 2)) *
             (0.5f + 0.9f * fractal(material.seed + 1, p * 1.3f, 3));
    case Kind::paving:
      return bricks(material, p, true) * (0.7f + 0.6f * fractal(material.seed + 9, p * 2.0f, 3));
    case Kind::crowd:
      return crowd(material, p);
    case Kind::stones: {
      float own = 0;
      const float d = cells(material.seed, vec2(p.x, p.y) / s, own);
      return (d > 0.52f ? material.b : glm::mix(material.a, material.c, own)) *
             (0.6f + 0.7f * fractal(material.seed + 1, p / s * 5.0f, 3));
    }
    case Kind::herringbone:
      return herringbone(material, p);
    case Kind::graffiti:
      return graffiti(material, p);
    default:
      return material.a;
  }
}

}  // namespace dualpixel::scenes
