#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

/// Signed distances: meters, negative inside, close to exact near the surface. Inline, as each figure evaluates them
/// millions of times.
namespace dualpixel::scenes {

using glm::mat3;
using glm::vec2;
using glm::vec3;

inline float ellipsoid(vec3 p, vec3 center, vec3 radii) {
  const vec3 q = (p - center) / radii;
  const float k0 = glm::length(q), k1 = glm::length(q / radii);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

/// A round cone from a to b.
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
/// Difference (a without b) with the same fillet.
inline float carve(float a, float b, float k) { return -blend(-a, b, k); }

/// The cranium: origin in the middle between the ears, y up, z towards the face.
inline constexpr vec3 kSkullCenter{0, 0.035f, -0.012f}, kSkullRadii{0.077f, 0.1f, 0.096f};
inline float skull(vec3 p) { return ellipsoid(p, kSkullCenter, kSkullRadii); }

}  // namespace dualpixel::scenes
