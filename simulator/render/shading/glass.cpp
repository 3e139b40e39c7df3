#include "simulator/render/shading/glass.h"

#include <algorithm>
#include <cmath>

#include "simulator/render/shading/layers.h"
#include "simulator/render/shading/microfacets.h"

namespace dualpixel::simulator {
namespace {

float largest_of(glm::vec3 rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

/// What coat and sheen leave of light that passes them, by the cosines against the surface at which it comes and goes:
/// as layered_bsdf() has it, whose lobes hold the rest.
float below_layers(const Layers& y, float n_v, float n_l) {
  const float coats = (1 - coat_reflects(y, n_v)) * (1 - coat_reflects(y, n_l)), sheen = largest_of(y.sheen_color);
  if (sheen == 0) return coats;
  return coats * (1 - sheen * std::max(sheen_albedo(y.sheen_roughness, n_v), sheen_albedo(y.sheen_roughness, n_l)));
}

/// Share that goes in or out below the layers where all that is not reflected does. Transmission is what of the light
/// that enters is not taken by the diffuse or metallic base: of light inside, all may leave.
glm::vec3 tint(const Surface& s, bool leaves) {
  const float enters = leaves ? 1 : s.layers->transmission * (1 - s.metallic);
  return enters * s.base_color;
}

/// That light is bent by: an ior of 0 stands for full reflection, and bends nothing by itself.
float bending_ior(const Layers& y) { return y.ior == 0 ? 1.5f : y.ior; }

float reflected_at(const Layers& y, float cosine) { return largest_of(fresnel(y, cosine)); }

/// Masking by other microfacets, over the density with which sample_ggx() finds `half`.
float rough_share(float n_v, float n_l, float v_h, float n_h, float alpha) {
  return 4 * ggx_visibility(n_l, n_v, alpha) * n_l * v_h / n_h;
}

}  // namespace

glm::vec3 passing(const Surface& s, float cosine, bool leaves) {
  return tint(s, leaves) * below_layers(*s.layers, cosine, cosine) * (1 - reflected_at(*s.layers, cosine));
}

bool refract(glm::vec3 to_eye, glm::vec3 normal, float eta, glm::vec3& direction) {
  const float cosine = glm::dot(to_eye, normal);
  const float squared = 1 - eta * eta * (1 - cosine * cosine);
  if (squared <= 0) return false;
  direction = glm::normalize((eta * cosine - std::sqrt(squared)) * normal - eta * to_eye);
  return true;
}

float stays(const Surface& s, glm::vec3 to_eye) {
  constexpr float kLeast = 0.15f;  // so that what glass shows of lamps is not a few bright samples
  const float cosine = std::max(glm::dot(s.normal, to_eye), 0.0f);
  return std::clamp(1 - largest_of(passing(s, cosine, false)), kLeast, 1.0f);
}

Passage sample_passage(const Surface& s, glm::vec3 to_eye, bool leaves, float choice, float u, float v) {
  const Layers& y = *s.layers;
  const bool clear = s.roughness < kClearRoughness, solid = y.solid;
  const float alpha = ggx_alpha(s.roughness);
  glm::vec3 half = clear ? s.normal : sample_ggx(s.normal, alpha, u, v);
  if (clear && glm::dot(half, to_eye) <= 0) half = s.geometric_normal;
  const float v_h = glm::dot(to_eye, half), n_v = std::max(glm::dot(s.normal, to_eye), 1e-4f);
  if (v_h <= 0) return {};
  const glm::vec3 back = 2 * v_h * half - to_eye;  // mirrored at the microfacet
  glm::vec3 through = -to_eye;
  bool all_reflected = false;
  if (solid) {
    const float ior = bending_ior(y);
    all_reflected = !refract(to_eye, half, leaves ? ior : 1 / ior, through);
  } else if (!clear) {
    through = back - 2 * glm::dot(back, s.normal) * s.normal;
  }
  const float outside = leaves ? std::abs(glm::dot(through, half)) : v_h;
  const float reflects = all_reflected ? 1 : reflected_at(y, outside);
  const bool reflected = leaves && choice < reflects;
  Passage passage;
  passage.direction = reflected ? back : through;
  // Shading normals and microfacets may lead to the wrong side of the triangles.
  const float side = glm::dot(passage.direction, s.geometric_normal);
  if (reflected ? side <= 0 : side >= 0) return {};
  const float n_l = std::max(std::abs(glm::dot(s.normal, passage.direction)), 1e-4f);
  passage.share = glm::vec3(1);
  if (!reflected) {
    // layers lie outside of solid glass; a pane's light passes them where it comes and where it goes
    const float layers_v = clear ? outside : leaves ? n_l : n_v, layers_l = clear || solid ? layers_v : n_l;
    passage.share = tint(s, leaves) * below_layers(y, layers_v, layers_l) * (leaves ? 1 : 1 - reflects);
  }
  if (!clear) {
    passage.share *= rough_share(n_v, n_l, v_h, std::max(glm::dot(s.normal, half), 1e-4f), alpha);
  }
  return passage;
}

glm::vec3 absorbed(const Layers& layers, float distance_m) { return glm::exp(-layers.absorption_per_m * distance_m); }

}  // namespace dualpixel::simulator
