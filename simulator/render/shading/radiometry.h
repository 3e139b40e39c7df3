#pragma once
#include <glm/glm.hpp>
#include <numbers>

namespace dualpixel::simulator {

inline constexpr float kPi = std::numbers::pi_v<float>;

/// Of linear sRGB.
inline float luminance(glm::vec3 rgb) { return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z; }

}  // namespace dualpixel::simulator
