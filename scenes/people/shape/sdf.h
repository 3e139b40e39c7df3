#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

/// Signed distances (meters, negative inside; near enough to true ones beside the surface) and smooth noise, inline:
/// they are called a million times for each figure.
namespace dualpixel::scenes {

using glm::mat3;
using glm::vec2;
using glm::vec3;

inline float ellipsoid(vec3 p, vec3 center, vec3 radii) {
  const vec3 q = (p - center) / radii;
  const float k0 = glm::length(q), k1 = glm::length(q / radii);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

inline float capsule(vec3 p, vec3 a, vec3 b, float radius_a, float radius_b) {
  const vec3 ab = b - a;
  const float t = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-12f), 0.0f, 1.0f);
  return glm::length(p - a - t * ab) - (radius_a + (radius_b - radius_a) * t);
}

/// Union with a fillet of about k meters.
inline float blend(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}
inline float carve(float a, float b, float k) { return -blend(-a, b, k); }

inline float hash01(std::uint32_t seed, int x, int y = 0, int z = 0) {
  std::uint32_t h = seed * 0x9e3779b9u + 0x85ebca6bu;
  for (const int v : {x, y, z}) {
    h ^= static_cast<std::uint32_t>(v) * 0xcc9e2d51u;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  }
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1p-24f;
}

/// Smooth noise in [0, 1], one cell a unit.
inline float noise(std::uint32_t seed, vec3 p) {
  const vec3 base = glm::floor(p), t = p - base, f = t * t * (3.0f - 2.0f * t);
  const glm::ivec3 i(base);
  float corner[8];
  for (int c = 0; c < 8; ++c) corner[c] = hash01(seed, i.x + (c & 1), i.y + ((c >> 1) & 1), i.z + (c >> 2));
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  return mix(mix(mix(corner[0], corner[1], f.x), mix(corner[2], corner[3], f.x), f.y),
             mix(mix(corner[4], corner[5], f.x), mix(corner[6], corner[7], f.x), f.y), f.z);
}

/// Octaves of it, each twice as fine and `gain` times as strong: about [0, 1], mean 1/2.
inline float fractal(std::uint32_t seed, vec3 p, int octaves, float gain = 0.6f) {
  float sum = 0, weight = 1, total = 0;
  for (int i = 0; i < octaves; ++i, weight *= gain, p *= 2.03f) {
    sum += weight * noise(seed + i, p);
    total += weight;
  }
  return sum / total;
}

}  // namespace dualpixel::scenes
