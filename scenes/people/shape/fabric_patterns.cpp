#include "scenes/people/shape/patterns.h"

namespace dualpixel::scenes {

vec3 fabric_pattern(const Material& material, vec3 p) {
  using Kind = Material::Kind;
  const float s = material.scale_m;
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
      return ink ? glm::mix(material.b, material.c,
                            smooth_step(noise(material.seed + 1, vec3(q, 0) * 4.0f) - 0.5f, 0.1f))
                 : material.a;
    }
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
    default:
      return material.a;
  }
}

}  // namespace dualpixel::scenes
