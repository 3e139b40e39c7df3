#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>

/// Value noise that depends on its arguments alone: the same on every machine.
namespace dualpixel::scenes {

/// Uniform in [0, 1).
inline float hash01(std::uint32_t seed, int x, int y = 0, int z = 0) {
  std::uint32_t h = seed * 0x9e3779b9u + 0x85ebca6bu;
  for (const int v : {x, y, z}) {
    h ^= static_cast<std::uint32_t>(v) * 0xcc9e2d51u;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  }
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1p-24f;
}

/// Smooth noise in [0, 1], one cell per unit.
inline float noise(std::uint32_t seed, glm::vec3 p) {
  const glm::vec3 base = glm::floor(p), t = p - base, f = t * t * (3.0f - 2.0f * t);
  const glm::ivec3 i(base);
  float corner[8];
  for (int c = 0; c < 8; ++c) corner[c] = hash01(seed, i.x + (c & 1), i.y + ((c >> 1) & 1), i.z + (c >> 2));
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  return mix(mix(mix(corner[0], corner[1], f.x), mix(corner[2], corner[3], f.x), f.y),
             mix(mix(corner[4], corner[5], f.x), mix(corner[6], corner[7], f.x), f.y), f.z);
}

/// Octaves of it, each about twice as fine and `gain` times as strong: about [0, 1], mean 1/2.
inline float fractal(std::uint32_t seed, glm::vec3 p, int octaves, float gain = 0.6f) {
  float sum = 0, weight = 1, total = 0;
  for (int i = 0; i < octaves; ++i, weight *= gain, p *= 2.03f) {
    sum += weight * noise(seed + i, p);
    total += weight;
  }
  return sum / total;
}

}  // namespace dualpixel::scenes
