#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "simulator/render/shading/radiometry.h"

/// GGX microfacets, and frames around a normal, which all reflection models share.
namespace dualpixel::simulator {

/// GGX's alpha; floored where the lobe would become a delta function.
inline float ggx_alpha(float roughness) { return std::max(roughness * roughness, 1e-3f); }

/// Density of normals per unit of projected area; `cos_half`: to the surface's normal.
inline float ggx_density(float cos_half, float alpha) {
  const float a2 = alpha * alpha;
  const float d = cos_half * cos_half * (a2 - 1) + 1;
  return a2 / (kPi * d * d);
}

/// Height-correlated Smith visibility, G / (4 n_l n_v).
inline float ggx_visibility(float n_l, float n_v, float alpha) {
  const float a2 = alpha * alpha;
  return 0.5f / (n_l * std::sqrt(n_v * n_v * (1 - a2) + a2) + n_v * std::sqrt(n_l * n_l * (1 - a2) + a2));
}

/// Any two unit vectors that complete `n` to a right-handed frame (Duff et al. 2017).
inline void frame(glm::vec3 n, glm::vec3& x, glm::vec3& y) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1 / (sign + n.z);
  const float b = n.x * n.y * a;
  x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  y = {b, sign + n.y * n.y * a, -n.y};
}

/// A direction whose z component, towards `normal`, is `cosine`.
inline glm::vec3 around(glm::vec3 normal, float cosine, float phi) {
  glm::vec3 x, y;
  frame(normal, x, y);
  const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
  return sine * std::cos(phi) * x + sine * std::sin(phi) * y + cosine * normal;
}

/// A microfacet's normal, with the density ggx_density() times its cosine.
inline glm::vec3 sample_ggx(glm::vec3 normal, float alpha, float u, float v) {
  const float cosine = std::sqrt((1 - u) / (1 + (alpha * alpha - 1) * u));
  return around(normal, cosine, 2 * kPi * v);
}

}  // namespace dualpixel::simulator
