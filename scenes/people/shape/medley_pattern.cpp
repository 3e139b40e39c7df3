#include "scenes/people/shape/patterns.h"

#include <numbers>

namespace dualpixel::scenes {
namespace {

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

}  // namespace

vec3 medley_pattern(const Material& material, vec3 p) {
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
    return smooth_step(value - (0.3f + 0.4f * random(4)) + 0.5f * softness, softness);
  };
  const vec3 one = glm::mix(material.a, material.b, tone(0, 1));
  const float mixing = hash01(material.seed, 5, 0, 3);
  if (mixing < 0.35f) return one;
  const vec3 other = glm::mix(material.c, mixing < 0.7f ? material.a : material.b, tone(1, 1.7f));
  return glm::mix(one, other, tone(2, 0.4f));
}

}  // namespace dualpixel::scenes
