#include "simulator/render/shading/bsdf.h"

#include <algorithm>
#include <cmath>

#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

bool is_lambertian(const Surface& s) { return s.metallic == 0 && s.roughness >= 1; }

/// GGX's alpha; floored where the lobe would become a delta function.
float ggx_alpha(const Surface& s) { return std::max(s.roughness * s.roughness, 1e-3f); }

float ggx_density(float cos_half, float alpha) {
  const float a2 = alpha * alpha;
  const float d = cos_half * cos_half * (a2 - 1) + 1;
  return a2 / (kPi * d * d);
}

/// Any two unit vectors that complete `n` to a right-handed frame (Duff et al. 2017).
void frame(glm::vec3 n, glm::vec3& x, glm::vec3& y) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1 / (sign + n.z);
  const float b = n.x * n.y * a;
  x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  y = {b, sign + n.y * n.y * a, -n.y};
}

}  // namespace

glm::vec3 bsdf(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light) {
  if (is_lambertian(s)) return s.base_color / kPi;
  const float n_l = glm::dot(s.normal, to_light);
  const float n_v = std::max(glm::dot(s.normal, to_eye), 1e-4f);
  if (n_l <= 0) return glm::vec3(0);
  const glm::vec3 half = glm::normalize(to_eye + to_light);
  const float n_h = std::max(glm::dot(s.normal, half), 0.0f);
  const float grazing = std::pow(1 - std::clamp(glm::dot(to_eye, half), 0.0f, 1.0f), 5.0f);
  const float a2 = ggx_alpha(s) * ggx_alpha(s);
  // height-correlated Smith visibility, G / (4 n_l n_v)
  const float visibility =
      0.5f / (n_l * std::sqrt(n_v * n_v * (1 - a2) + a2) + n_v * std::sqrt(n_l * n_l * (1 - a2) + a2));
  const float coat = visibility * ggx_density(n_h, ggx_alpha(s));
  const float dielectric_fresnel = 0.04f + 0.96f * grazing;
  const glm::vec3 dielectric = (1 - dielectric_fresnel) * s.base_color / kPi + dielectric_fresnel * coat;
  const glm::vec3 metal = (s.base_color + (1.0f - s.base_color) * grazing) * coat;
  return glm::mix(dielectric, metal, s.metallic);
}

glm::vec3 diffuse_bsdf(const Surface& s) {
  return is_lambertian(s) ? s.base_color / kPi : (1 - s.metallic) * (1 - 0.04f) * s.base_color / kPi;
}

namespace {

/// How often sample_bsdf() takes the cosine lobe rather than the coat's: a metal has nothing diffuse.
float cosine_share(const Surface& s) { return is_lambertian(s) ? 1 : 0.5f * (1 - s.metallic); }

}  // namespace

float bsdf_pdf(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light) {
  const float cosine = std::max(glm::dot(s.normal, to_light), 0.0f) / kPi;
  if (is_lambertian(s)) return cosine;
  const glm::vec3 half = glm::normalize(to_eye + to_light);
  const float n_h = std::max(glm::dot(s.normal, half), 0.0f);
  const float v_h = std::max(glm::dot(to_eye, half), 1e-4f);
  const float diffuse = cosine_share(s);
  return diffuse * cosine + (1 - diffuse) * ggx_density(n_h, ggx_alpha(s)) * n_h / (4 * v_h);
}

glm::vec3 sample_bsdf(const Surface& s, glm::vec3 to_eye, float u, float v) {
  glm::vec3 x, y;
  frame(s.normal, x, y);
  const float diffuse = cosine_share(s);
  const bool cosine_lobe = u < diffuse;
  u = cosine_lobe ? u / diffuse : (u - diffuse) / (1 - diffuse);
  const float phi = 2 * kPi * v;
  if (cosine_lobe) {
    const float r = std::sqrt(u);
    return r * std::cos(phi) * x + r * std::sin(phi) * y + std::sqrt(std::max(1 - u, 0.0f)) * s.normal;
  }
  const float a2 = ggx_alpha(s) * ggx_alpha(s);
  const float cos_half = std::sqrt((1 - u) / (1 + (a2 - 1) * u));
  const float sin_half = std::sqrt(std::max(1 - cos_half * cos_half, 0.0f));
  const glm::vec3 half = sin_half * std::cos(phi) * x + sin_half * std::sin(phi) * y + cos_half * s.normal;
  return 2 * glm::dot(to_eye, half) * half - to_eye;
}

}  // namespace dualpixel::simulator
