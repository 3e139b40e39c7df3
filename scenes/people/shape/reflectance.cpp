#include "scenes/people/shape/reflectance.h"

#include "scenes/people/shape/patterns.h"
#include "simulator/render/shading/surface.h"

namespace dualpixel::scenes {

vec3 reflectance(const Material& material, vec3 p) {
  using Kind = Material::Kind;
  if (material.v[kPlacket] > 0 && material.kind < Kind::skin && p.z > 0 && std::abs(p.x) < 0.02f) {
    const float button = glm::length(vec2(p.x, 0.09f * (saw(p.y / 0.09f) - 0.5f)));
    const float edge = std::abs(p.x - 0.017f);
    if (button < 0.006f) return glm::mix(material.a, material.c, material.v[kPlacket]);
    if (edge < 0.002f) return material.a * (1 - 0.6f * material.v[kPlacket]);
  }
  switch (material.kind) {
    case Kind::skin:
      return material.a * (0.92f + 0.16f * fractal(material.seed, p * 40.0f, 3)) *
             glm::mix(vec3(1), vec3(1.02f, 0.93f, 0.92f), noise(material.seed + 2, p * 15.0f));
    case Kind::face:
      return face_pattern(material, p);
    case Kind::eye:
      return eye_pattern(material, p);
    case Kind::hair:
      return hair_pattern(material, p);
    case Kind::medley:
      return medley_pattern(material, p);
    case Kind::textured:
      return material.a * vec3(simulator::sample_texture(*material.texture, {p.x, p.y}));
    default:
      return material.kind < Kind::skin ? fabric_pattern(material, p) : environment_pattern(material, p);
  }
}

}  // namespace dualpixel::scenes
