#include "scenes/test_targets/noise.h"

#include <algorithm>
#include <cmath>

#include "capture/image/image_io.h"

namespace dualpixel::scenes {
namespace {

float smooth(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

int floor_mod(int a, int n) { return ((a % n) + n) % n; }

}  // namespace

float scene_hash01(std::uint32_t seed, int x, int y, int z) {
  std::uint32_t h = seed * 0x9e3779b9u + 0x85ebca6bu;
  for (int v : {x, y, z}) {
    h ^= static_cast<std::uint32_t>(v) * 0xcc9e2d51u;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
  }
  return static_cast<float>(h >> 8) * 0x1p-24f;
}

float value_noise(std::uint32_t seed, glm::vec3 p) {
  const glm::vec3 base = glm::floor(p);
  const glm::ivec3 i(base);
  const glm::vec3 f = p - base;
  const float x = smooth(f.x), y = smooth(f.y), z = smooth(f.z);
  float corner[8];
  for (int c = 0; c < 8; ++c) corner[c] = scene_hash01(seed, i.x + (c & 1), i.y + ((c >> 1) & 1), i.z + (c >> 2));
  const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
  return mix(mix(mix(corner[0], corner[1], x), mix(corner[2], corner[3], x), y),
             mix(mix(corner[4], corner[5], x), mix(corner[6], corner[7], x), y), z);
}

float fractal_noise(std::uint32_t seed, glm::vec3 p, float lowest, int octaves, float gain) {
  float sum = 0, weight = 1, total = 0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += weight * value_noise(seed + octave, p * lowest);
    total += weight;
    lowest *= 2;
    weight *= gain;
  }
  return sum / total;
}

Texture noise_texture(std::uint32_t seed, int size, int lowest, int highest, float gain,
                      const std::function<glm::vec3(float, float, float)>& linear_color) {
  std::vector<float> noise(static_cast<std::size_t>(size) * size, 0.0f);
  float total = 0, weight = 1;
  for (int cells = lowest; cells <= highest; cells *= 2, weight *= gain) {
    total += weight;
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const float u = (x + 0.5f) / size * cells, v = (y + 0.5f) / size * cells;
        const int i = static_cast<int>(u), j = static_cast<int>(v);
        const float a = smooth(u - i), b = smooth(v - j);
        const auto at = [&](int m, int n) {
          return scene_hash01(seed + cells, floor_mod(i + m, cells), floor_mod(j + n, cells));
        };
        noise[static_cast<std::size_t>(y) * size + x] +=
            weight * ((at(0, 0) * (1 - a) + at(1, 0) * a) * (1 - b) + (at(0, 1) * (1 - a) + at(1, 1) * a) * b);
      }
    }
  }
  Texture texture{size, std::vector<std::uint8_t>(noise.size() * 3)};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * size + x;
      // octaves average out: stretch about the middle so that the whole range is used
      const float n = std::clamp((noise[i] / total - 0.5f) * 2.2f + 0.5f, 0.0f, 1.0f);
      const glm::vec3 color = linear_color(n, (x + 0.5f) / size, (y + 0.5f) / size);
      for (int c = 0; c < 3; ++c) {
        texture.rgb[i * 3 + c] = static_cast<std::uint8_t>(srgb_from_linear(color[c]) * 255 + 0.5f);
      }
    }
  }
  return texture;
}

Texture two_tone(std::uint32_t seed, glm::vec3 dark, glm::vec3 bright, int lowest, int highest, float gain) {
  return noise_texture(seed, 1024, lowest, highest, gain,
                       [&](float n, float, float) { return glm::mix(dark, bright, n); });
}

}  // namespace dualpixel::scenes
