#include "simulator/render/shading/bsdf.h"

#include <algorithm>
#include <cmath>

#include "simulator/render/shading/hair.h"
#include "simulator/render/shading/layers.h"
#include "simulator/render/shading/microfacets.h"

namespace dualpixel::simulator {
namespace {

bool is_lambertian(const Surface& s) { return s.metallic == 0 && s.roughness >= 1 && !s.layers && !s.hair; }

HairStrand strand_of(const Surface& s) { return {s.tangent, s.across, s.base_color, s.roughness}; }

}  // namespace

glm::vec3 bsdf(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light) {
  if (is_lambertian(s)) return s.base_color / kPi;
  if (s.hair) {
    const float cosine = std::max(glm::dot(s.normal, to_light), 1e-6f);
    return hair_scattering(strand_of(s), to_eye, to_light) * (2 / cosine);
  }
  if (s.layers) return layered_bsdf(s, to_eye, to_light);
  const float n_l = glm::dot(s.normal, to_light);
  const float n_v = std::max(glm::dot(s.normal, to_eye), 1e-4f);
  if (n_l <= 0) return glm::vec3(0);
  const glm::vec3 half = glm::normalize(to_eye + to_light);
  const float n_h = std::max(glm::dot(s.normal, half), 0.0f);
  const float grazing = std::pow(1 - std::clamp(glm::dot(to_eye, half), 0.0f, 1.0f), 5.0f);
  const float alpha = ggx_alpha(s.roughness);
  const float coat = ggx_visibility(n_l, n_v, alpha) * ggx_density(n_h, alpha);
  const float dielectric_fresnel = 0.04f + 0.96f * grazing;
  const glm::vec3 dielectric = (1 - dielectric_fresnel) * s.base_color / kPi + dielectric_fresnel * coat;
  const glm::vec3 metal = (s.base_color + (1.0f - s.base_color) * grazing) * coat;
  return glm::mix(dielectric, metal, s.metallic);
}

glm::vec3 diffuse_bsdf(const Surface& s) {
  if (s.hair) return glm::vec3(0);
  if (s.layers) return layered_diffuse_bsdf(s);
  return is_lambertian(s) ? s.base_color / kPi : (1 - s.metallic) * (1 - 0.04f) * s.base_color / kPi;
}

namespace {

/// How often sample_bsdf() takes the cosine lobe rather than the coat's: a metal has nothing diffuse.
float cosine_share(const Surface& s) { return is_lambertian(s) ? 1 : 0.5f * (1 - s.metallic); }

}  // namespace

float bsdf_pdf(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light) {
  const float cosine = std::max(glm::dot(s.normal, to_light), 0.0f) / kPi;
  if (is_lambertian(s)) return cosine;
  if (s.hair) return 2 * hair_pdf(strand_of(s), to_eye, to_light);
  if (s.layers) return layered_pdf(s, to_eye, to_light);
  const glm::vec3 half = glm::normalize(to_eye + to_light);
  const float n_h = std::max(glm::dot(s.normal, half), 0.0f);
  const float v_h = std::max(glm::dot(to_eye, half), 1e-4f);
  const float diffuse = cosine_share(s);
  return diffuse * cosine + (1 - diffuse) * ggx_density(n_h, ggx_alpha(s.roughness)) * n_h / (4 * v_h);
}

glm::vec3 sample_bsdf(const Surface& s, glm::vec3 to_eye, float u, float v) {
  if (s.layers) return sample_layered(s, to_eye, u, v);
  const float diffuse = cosine_share(s);
  const bool cosine_lobe = u < diffuse;
  u = cosine_lobe ? u / diffuse : (u - diffuse) / (1 - diffuse);
  if (cosine_lobe) {
    glm::vec3 x, y;
    frame(s.normal, x, y);
    const float phi = 2 * kPi * v;
    const float r = std::sqrt(u);
    return r * std::cos(phi) * x + r * std::sin(phi) * y + std::sqrt(std::max(1 - u, 0.0f)) * s.normal;
  }
  const glm::vec3 half = sample_ggx(s.normal, ggx_alpha(s.roughness), u, v);
  return 2 * glm::dot(to_eye, half) * half - to_eye;
}

glm::vec3 sample_strand(Surface& s, glm::vec3 to_eye, const std::array<float, 4>& numbers) {
  const glm::vec3 direction = sample_hair(strand_of(s), to_eye, numbers);
  if (glm::dot(direction, s.normal) < 0) s.normal = -s.normal, s.geometric_normal = -s.geometric_normal;
  return direction;
}

}  // namespace dualpixel::simulator
