#pragma once
#include <cstdint>
#include <functional>

#include "scenes/gltf/glb.h"

/// The noise of the shipped scenes. It is kept apart from procedural/noise.h: hash and fade differ, and another noise,
/// or the same arithmetic inlined elsewhere, would change the bytes of the shipped glTF files.
namespace dualpixel::scenes {

/// Uniform in [0, 1).
float scene_hash01(std::uint32_t seed, int x, int y = 0, int z = 0);

/// Smooth noise in [0, 1], one cell per unit.
float value_noise(std::uint32_t seed, glm::vec3 p);

/// Octaves of value noise from `lowest` cells per unit, each twice as fine and `gain` times as strong; about [0, 1].
float fractal_noise(std::uint32_t seed, glm::vec3 p, float lowest, int octaves, float gain);

/// A square texture that repeats seamlessly: color(n) of fractal noise n from `lowest` to `highest` cells across.
Texture noise_texture(std::uint32_t seed, int size, int lowest, int highest, float gain,
                      const std::function<glm::vec3(float n, float u, float v)>& linear_color);

/// A texture of 1024 texels a side between two linear colors; else as noise_texture().
Texture two_tone(std::uint32_t seed, glm::vec3 dark, glm::vec3 bright, int lowest, int highest, float gain);

}  // namespace dualpixel::scenes
