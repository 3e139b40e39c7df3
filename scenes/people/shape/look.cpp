#include "scenes/people/shape/look.h"

#include <numbers>

#include "scenes/people/shape/sdf.h"
#include "simulator/render/shading/surface.h"

namespace dualpixel::scenes {
namespace {

using Kind = Material::Kind;

constexpr Kind kCloth[] = {
    Kind::plain,  Kind::plain,  Kind::plain,  Kind::heather, Kind::heather, Kind::stripes_across, Kind::stripes_along,
    Kind::checks, Kind::dots,   Kind::floral, Kind::knit,    Kind::denim,   Kind::print,          Kind::medley,
    Kind::medley, Kind::medley, Kind::medley, Kind::medley,  Kind::argyle,  Kind::zigzag,         Kind::camouflage};
constexpr Kind kWall[] = {Kind::rough,  Kind::rough,   Kind::plain,  Kind::bricks,        Kind::planks,
                          Kind::tiles,  Kind::collage, Kind::floral, Kind::stripes_along, Kind::facade,
                          Kind::books,  Kind::foliage, Kind::medley, Kind::medley,        Kind::medley,
                          Kind::medley, Kind::medley,  Kind::stones, Kind::herringbone,   Kind::graffiti};

/// 0 below 0, 1 above `width`, smooth between.
float step(float x, float width = 1) {
  const float t = std::clamp(x / width, 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

float saw(float x) { return x - std::floor(x); }
/// 0 .. 1 .. 0 over one repeat.
float triangle(float x) { return 1 - std::abs(2 * saw(x) - 1); }

/// Distance to the nearest of scattered points, one to a unit square, and a number of its own.
float cells(std::uint32_t seed, vec2 p, float& own) {
  const glm::ivec2 base(glm::floor(p));
  float nearest = 9;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const int x = base.x + i, y = base.y + j;
      const float d = glm::distance(p, vec2(x, y) + vec2(hash01(seed, x, y), hash01(seed, x, y, 1)));
      if (d >= nearest) continue;
      nearest = d;
      own = hash01(seed, x, y, 2);
    }
  }
  return nearest;
}

float gaussian(vec3 d, vec3 sigma) {
  const vec3 q = d / sigma;
  return std::exp(-0.5f * glm::dot(q, q));
}

vec3 face(const Material& material, vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);
  const float mottle = fractal(material.seed, p * 45.0f, 3) - 0.5f;
  vec3 color = material.a * (1 + 0.14f * mottle);
  const bool front = p.z > 0.02f;
  // blood under cheeks, nose and ears
  float red = 0.5f * material.v[kBlush] * gaussian(s - vec3(0.044f, -0.02f, 0.06f), {0.018f, 0.015f, 0.03f});
  red += 0.4f * material.v[kBlush] * gaussian(p - vec3(0, -0.02f, 0.1f), {0.011f, 0.011f, 0.02f});
  red += 0.25f * gaussian(s - vec3(0.085f, 0, -0.01f), {0.008f, 0.03f, 0.02f});
  color *= glm::mix(vec3(1), vec3(1.02f, 0.72f, 0.74f), std::min(red, 1.0f));
  // shadows under the eyes
  color *= 1 - 0.18f * gaussian(s - vec3(0.031f, 0.0f, 0.075f), {0.012f, 0.005f, 0.02f});
  if (!front) {
    const float scalp = step(p.y - 0.02f + 0.5f * p.z, 0.02f);
    return glm::mix(color, material.c, material.v[kScalpHair] * scalp);
  }
  const float scalp = step(p.y - 0.082f + 0.006f * std::sin(p.x * 90), 0.008f);
  color = glm::mix(color, material.c, material.v[kScalpHair] * scalp);
  // beard's shadow: jaw, chin, upper lip
  const float around_mouth = glm::length(vec2(p.x / 0.024f, (p.y + 0.0545f) / 0.0135f));
  const float beard =
      step(-0.03f - p.y + 0.45f * s.x, 0.02f) * step(around_mouth - 1, 0.25f) * step(p.y + 0.13f, 0.02f);
  const float hairs = 0.6f + 0.8f * noise(material.seed + 7, p * 600.0f);
  color = glm::mix(color, material.c * 1.3f, std::clamp(material.v[kStubble] * beard * hairs, 0.0f, 0.95f));
  // brows
  const float along = (s.x - 0.012f) / 0.038f;
  if (along > 0 && along < 1) {
    const float height = 0.034f + 0.008f * std::sin(2.1f * along) - 0.002f * along;
    const float half = material.v[kBrowThickness] * 0.0062f * (1.1f - 0.75f * along);
    const float brow =
        step(half - std::abs(p.y - height), 0.0025f) * (0.65f + 0.5f * noise(material.seed + 9, p * 500.0f));
    color = glm::mix(color, material.c, std::clamp(brow, 0.0f, 0.9f));
  }
  // lashes: a dark rim about the eye's opening, stronger above
  const vec2 eye((s.x - 0.031f) / 0.0165f, (p.y - 0.0145f) / 0.0085f);
  const float rim = std::exp(-14 * (glm::length(eye) - 1) * (glm::length(eye) - 1));
  color *= 1 - rim * (eye.y > 0 ? 0.45f + 0.5f * material.v[kEyeLine] : 0.2f + 0.4f * material.v[kEyeLine]);
  // lips and what shows between them
  const float lips = std::min(ellipsoid(p, {0, -0.0485f, 0.078f}, {0.0236f, 0.0062f, 0.02f}),
                              ellipsoid(p, {0, -0.0605f, 0.077f}, {0.0208f, 0.007f, 0.02f}));
  color = glm::mix(color, material.b, step(0.0012f - lips, 0.0016f));
  const float open = material.v[kMouthOpen];
  const float corner = 0.006f * (s.x / 0.02f) * (s.x / 0.02f);
  const float slit = std::abs(p.y + 0.0545f - (open > 0.3f ? corner : 0.0f)) -
                     (0.0008f + 0.0052f * open) * std::sqrt(std::max(0.0f, 1 - s.x * s.x / (0.021f * 0.021f)));
  if (slit < 0 && s.x < 0.021f && p.z > 0.05f) {
    const bool teeth = open > 0.3f && p.y > -0.0585f;
    color = teeth ? vec3(0.62f, 0.57f, 0.49f) * (0.8f + 0.2f * triangle(p.x / 0.0075f)) : vec3(0.06f, 0.02f, 0.02f);
  }
  // nostrils
  return color * (1 - 0.75f * gaussian(s - vec3(0.0068f, -0.0305f, 0.095f), {0.003f, 0.0028f, 0.02f}));
}

vec3 eye(const Material& material, vec3 d) {
  const float r = std::sqrt(d.x * d.x + d.y * d.y);
  if (d.z > 0 && r < 0.17f) return vec3(0.01f);
  if (d.z > 0 && glm::length(vec2(d.x + 0.12f, d.y - 0.14f)) < 0.06f) return vec3(1.6f);  // a window's reflection
  if (d.z > 0 && r < 0.48f) return material.a * (r > 0.43f ? 0.35f : 0.7f + 0.6f * noise(material.seed, d * 30.0f));
  return vec3(0.52f, 0.48f, 0.46f) - vec3(0, 0.08f, 0.1f) * step(r - 0.7f, 0.3f);
}

vec3 hair(const Material& material, vec3 p) {
  // streaks run downwards: fine around the head, long along it
  const float around = std::atan2(p.x, p.z);
  const float streak = noise(material.seed, {around * 40, p.y * 9, 5 * glm::length(vec2(p.x, p.z))});
  const float fine = noise(material.seed + 3, {around * 150, p.y * 25, 20 * p.z});
  const float tone = 0.45f + 0.7f * streak + 0.5f * (fine - 0.5f);
  return glm::mix(material.a, material.b, step(streak - 0.55f, 0.5f)) * std::max(tone, 0.15f);
}

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
    color = glm::mix(color, glm::mix(patch * patch, material.c, 0.35f), step(radius - d, 0.03f + 0.15f * saw(own * 3)));
  }
  return color;
}

vec3 foliage(const Material& material, vec3 p) {
  float own = 0, other = 0;
  const vec2 q = vec2(p.x + 0.4f * p.z, p.y) / material.scale_m;
  const float wobble = 2 * noise(material.seed + 5, p / material.scale_m * 0.7f);
  const float d = cells(material.seed, q + wobble, own), e = cells(material.seed + 3, q * 0.45f, other);
  const float light = step(fractal(material.seed + 8, p / material.scale_m * 0.22f, 3) - 0.3f, 0.5f);
  const vec3 leaf = glm::mix(material.a, material.c, 0.5f * own + 0.5f * other);
  return leaf * (0.15f + 1.1f * light * (0.35f + 0.65f * own)) * (1 - 0.55f * step(d - 0.35f, 0.4f)) *
         (1 - 0.4f * step(e - 0.5f, 0.3f));
}

vec3 crowd(const Material& material, vec3 p) {
  const float place = p.x / material.scale_m;
  const int n = static_cast<int>(std::floor(place));
  const float tall = material.scale_m * (2.6f + 0.9f * hash01(material.seed, n)), x = saw(place) - 0.5f;
  const float y = p.y;
  const vec3 cloth(hash01(material.seed, n, 1), hash01(material.seed, n, 2), hash01(material.seed, n, 3));
  if (std::abs(x) < 0.38f * step(tall - y, 0.5f * material.scale_m)) return cloth * cloth * 0.7f;
  if (glm::length(vec2(x * material.scale_m, y - tall - 0.2f * material.scale_m)) < 0.22f * material.scale_m) {
    return glm::mix(vec3(0.08f, 0.04f, 0.025f), vec3(0.6f, 0.4f, 0.3f), hash01(material.seed, n, 4));
  }
  return glm::mix(material.a, material.b, fractal(material.seed, p, 3));
}

/// A pattern's tone, 0..1, where one repeat is 1.
float tone_of(int pattern, std::uint32_t seed, vec2 q) {
  switch (pattern) {
    case 0:  // bands, straight to wavy
      return triangle(q.x + 1.5f * hash01(seed, 1) * fractal(seed, vec3(0.6f * q, 0), 2));
    case 1: {  // rings about scattered points
      float own = 0;
      return triangle(2 * cells(seed, q, own) + own);
    }
    case 2:  // a lattice
      return std::max(triangle(q.x), triangle(q.y));
    case 3:  // cells of a grid, each of its own
      return hash01(seed, static_cast<int>(std::floor(q.x)), static_cast<int>(std::floor(q.y)));
    case 4:  // contour lines
      return triangle(5 * fractal(seed, vec3(q, 0), 2));
    case 5: {  // scattered chips
      float own = 0;
      return cells(seed, q, own) < 0.15f + 0.3f * own ? own : 0;
    }
    case 6: {  // halves of squares, each of its own
      const vec2 cell = glm::floor(q), within = q - cell;
      return hash01(seed, static_cast<int>(cell.x), static_cast<int>(cell.y), within.x > within.y ? 1 : 0);
    }
    case 7: {  // squares inside squares, or discs
      const vec2 d = glm::abs(q - glm::floor(q) - 0.5f);
      const float r = hash01(seed, 2) < 0.5f ? std::max(d.x, d.y) : glm::length(d);
      return triangle(r * (1 + 4 * hash01(seed, 3)));
    }
    case 8: {  // marks, as of letters and signs
      const vec2 fine = 5.0f * q;
      const glm::ivec2 mark(glm::floor(q)), stroke(glm::floor(fine));
      const bool gap = saw(q.x) > 0.8f || saw(q.y) > 0.6f;
      return gap || hash01(seed, mark.x, mark.y, 7) < 0.15f ? 0 : hash01(seed, stroke.x, stroke.y, 5);
    }
    case 9: {  // rays about the middle of each square
      const vec2 d = q - glm::floor(q) - 0.5f;
      return triangle(std::atan2(d.y, d.x) * (2 + std::floor(4 * hash01(seed, 2))) / std::numbers::pi_v<float> / 2);
    }
    case 10: {  // slopes, one to a square
      const vec2 cell = glm::floor(q);
      return saw(q.x - cell.x + hash01(seed, static_cast<int>(cell.x), static_cast<int>(cell.y)));
    }
    case 11:  // cloth of two waves
      return 0.5f + 0.5f * std::sin(5 * q.x + 2 * std::sin(3 * q.y)) * std::sin(4.1f * q.y + 2 * std::sin(2.3f * q.x));
    default: {  // bands of dashes
      const float row = std::floor(q.x);
      const float end = 3 * hash01(seed, static_cast<int>(row));
      return triangle(q.x) * (saw(0.4f * q.y + end) < 0.7f ? 1.0f : 0.0f);
    }
  }
}

vec3 medley(const Material& material, vec3 p) {
  constexpr int kPatterns = 13;
  const auto tone = [&](std::uint32_t layer, float repeats) {
    const std::uint32_t seed = material.seed + 31 * layer;
    const auto random = [&](int i) { return hash01(seed, i, 0, 3); };  // 5: `mixing` below
    const float angle = 2 * std::numbers::pi_v<float> * random(0), stretch = std::exp2(random(1) - 0.5f);
    const vec2 u(p.x + 0.3f * p.z, p.y);
    const vec2 q = vec2(std::cos(angle) * u.x + std::sin(angle) * u.y, std::cos(angle) * u.y - std::sin(angle) * u.x) *
                   vec2(stretch, 1 / stretch) * (repeats / material.scale_m);
    const float bend = random(6) < 0.7f ? 0 : 0.5f * random(7);
    const vec2 bent = q + bend * glm::sin(2.0f * vec2(q.y, q.x) + 6.0f * vec2(random(8), random(9)));
    const float value = tone_of(std::min(static_cast<int>(kPatterns * random(2)), kPatterns - 1), seed, bent);
    const float softness = random(3) < 0.6f ? 0.04f : 0.8f;  // sharp edges or shades
    return step(value - (0.3f + 0.4f * random(4)) + 0.5f * softness, softness);
  };
  const vec3 one = glm::mix(material.a, material.b, tone(0, 1));
  const float mixing = hash01(material.seed, 5, 0, 3);
  if (mixing < 0.35f) return one;
  const vec3 other = glm::mix(material.c, mixing < 0.7f ? material.a : material.b, tone(1, 1.7f));
  return glm::mix(one, other, tone(2, 0.4f));
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
    color = glm::mix(color, paint * paint, step(0.055f - line, 0.02f));
  }
  return color;
}

}  // namespace

vec3 reflectance(const Material& material, vec3 p) {
  const float s = material.scale_m;
  if (material.v[kPlacket] > 0 && material.kind < Kind::skin && p.z > 0 && std::abs(p.x) < 0.02f) {
    const float button = glm::length(vec2(p.x, 0.09f * (saw(p.y / 0.09f) - 0.5f)));
    const float edge = std::abs(p.x - 0.017f);
    if (button < 0.006f) return glm::mix(material.a, material.c, material.v[kPlacket]);
    if (edge < 0.002f) return material.a * (1 - 0.6f * material.v[kPlacket]);
  }
  switch (material.kind) {
    case Kind::plain:
      return material.a;
    case Kind::stripes_across:
      return saw(p.y / s) < 0.5f ? material.a : material.b;
    case Kind::stripes_along:
      return saw(p.x / s) < 0.5f ? material.a : material.b;
    case Kind::checks: {
      const int layers = (saw(p.x / s) < 0.5f ? 1 : 0) + (saw(p.y / s) < 0.5f ? 1 : 0);
      const bool line = saw(p.x / s + 0.25f) < 0.06f || saw(p.y / s + 0.25f) < 0.06f;
      return line ? material.c : glm::mix(material.a, material.b, 0.5f * static_cast<float>(layers));
    }
    case Kind::dots: {
      const float row = std::floor(p.y / s);
      const vec2 q(saw(p.x / s + 0.5f * std::fmod(std::abs(row), 2.0f)) - 0.5f, saw(p.y / s) - 0.5f);
      return glm::length(q) < 0.26f ? material.b : material.a;
    }
    case Kind::floral: {
      float own = 0;
      const float d = cells(material.seed, vec2(p.x + 0.3f * p.z, p.y) / s, own);
      const float petals = 0.33f + 0.1f * std::sin(own * 40 + 5 * std::atan2(saw(p.y / s) - 0.5f, saw(p.x / s) - 0.5f));
      return d < 0.12f ? material.c : d < petals ? glm::mix(material.b, material.c, own * 0.6f) : material.a;
    }
    case Kind::knit: {
      const float ribs = triangle(p.x / (0.3f * s)), rows = triangle(p.y / (0.22f * s) + 0.5f * ribs);
      return material.a * (0.6f + 0.45f * ribs + 0.15f * rows) * (0.85f + 0.3f * noise(material.seed, p * 60.0f));
    }
    case Kind::denim: {
      const float worn = fractal(material.seed, p * 7.0f, 3),
                  twill = noise(material.seed + 1, {(p.x + p.y) * 500, p.y * 90, p.z * 90});
      return glm::mix(material.a, material.b, std::clamp(1.6f * (worn - 0.35f) + 0.4f * (twill - 0.5f), 0.0f, 1.0f));
    }
    case Kind::heather:
      return material.a * (0.87f + 0.26f * fractal(material.seed, p * 80.0f, 2)) *
             (0.85f + 0.3f * fractal(material.seed + 4, p * 12.0f, 2));
    case Kind::print: {
      // a picture or lettering on the front, plain elsewhere
      const vec2 q((p.x) / (1.6f * s), (p.y - 0.02f) / (1.3f * s));
      if (p.z < 0 || std::abs(q.x) > 1 || std::abs(q.y) > 1) return material.a;
      const bool letters = (material.seed & 2) != 0;
      const float row = std::floor(q.y * 2.5f);
      const bool ink = letters ? saw(q.y * 2.5f) < 0.7f && noise(material.seed, {q.x * 9, row * 5, 0}) > 0.45f
                               : glm::length(q) < 0.75f + 0.3f * (noise(material.seed, {q.x * 4, q.y * 4, 0}) - 0.5f);
      return ink ? glm::mix(material.b, material.c, step(noise(material.seed + 1, vec3(q, 0) * 4.0f) - 0.5f, 0.1f))
                 : material.a;
    }
    case Kind::medley:
      return medley(material, p);
    case Kind::argyle: {
      const float u = p.x / s + p.y / (1.5f * s), w = p.x / s - p.y / (1.5f * s);
      if (std::min(std::abs(saw(u) - 0.5f), std::abs(saw(w) - 0.5f)) < 0.03f) return material.c;
      return (static_cast<int>(std::floor(u)) + static_cast<int>(std::floor(w))) % 2 == 0 ? material.a : material.b;
    }
    case Kind::zigzag:
      return saw((p.y + 0.5f * s * triangle(p.x / s)) / (0.8f * s)) < 0.5f ? material.a : material.b;
    case Kind::camouflage: {
      const float n = fractal(material.seed, p / s * 0.8f, 3), m = fractal(material.seed + 5, p / s, 3);
      return n > 0.56f ? material.b : m > 0.56f ? material.c : material.a;
    }
    case Kind::skin:
      return material.a * (0.92f + 0.16f * fractal(material.seed, p * 40.0f, 3)) *
             glm::mix(vec3(1), vec3(1.02f, 0.93f, 0.92f), noise(material.seed + 2, p * 15.0f));
    case Kind::face:
      return face(material, p);
    case Kind::eye:
      return eye(material, p);
    case Kind::hair:
      return hair(material, p);
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
    case Kind::textured:
      return material.a * vec3(simulator::sample_texture(*material.texture, {p.x, p.y}));
  }
  return material.a;
}

vec3 random_color(RandomStream& rng) {
  const auto from_hue = [&](float hue, float saturation, float value) {
    vec3 rgb;
    for (int c = 0; c < 3; ++c)
      rgb[c] = std::clamp(std::abs(saw(hue + static_cast<float>(3 - c) / 3) * 6 - 3) - 1, 0.0f, 1.0f);
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
  const float place = (kMeans - 1.001f) * std::pow(rng.uniform(), 0.75f);
  const int i = static_cast<int>(place);
  const vec3 color = glm::mix(mean[i], mean[i + 1], place - static_cast<float>(i));
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

}  // namespace dualpixel::scenes
