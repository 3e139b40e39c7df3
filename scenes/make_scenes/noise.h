#pragma once
#include <cstdint>
#include <functional>

#include "scenes/make_scenes/glb.h"

/// Noise that depends on its arguments alone: the same scenes on every machine.
namespace dualpixel::scenes {

/// Uniform in [0, 1).
float hash01(std::uint32_t seed, int x, int y = 0, int z = 0);

/// Smooth noise in [0, 1], one cell a unit.
float value_noise(std::uint32_t seed, glm::vec3 p);

/// Octaves of value noise from `lowest` cells a unit, each twice as fine and `gain` times as strong; about [0, 1].
float fractal_noise(std::uint32_t seed, glm::vec3 p, float lowest, int octaves, float gain);

/// A square texture that repeats seamlessly: color(n) of fractal noise n from `lowest` to `highest` cells across.
Texture noise_texture(std::uint32_t seed, int size, int lowest, int highest, float gain,
                      const std::function<glm::vec3(float n, float u, float v)>& linear_color);

}  // namespace dualpixel::scenes
