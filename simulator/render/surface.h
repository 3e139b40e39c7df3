#pragma once
#include <glm/glm.hpp>

#include "simulator/scene/scene.h"

/// What a ray finds where it meets a triangle: interpolated attributes, textures looked up, material resolved.
namespace dualpixel::simulator {

/// A point on a triangle with glTF's metallic-roughness material (glTF 2.0, Appendix B). Both sides of a surface look
/// the same; normals point to the side that the ray came from.
struct Surface {
  glm::vec3 position{0};
  glm::vec3 geometric_normal{0, 0, 1};  ///< unit
  glm::vec3 normal{0, 0, 1};            ///< unit: interpolated, normal-mapped
  glm::vec3 base_color{0};
  glm::vec3 emission_nits{0};
  float metallic = 0;
  float roughness = 1;
  float alpha = 1;
  bool unlit = false;
};

/// Bilinear (or nearest) lookup; linear RGB, alpha as stored.
glm::vec4 sample_texture(const Texture& texture, glm::vec2 uv);

/// `u`, `v`: Embree's barycentrics, weights of the triangle's second and third vertex.
Surface surface_at(const Scene& scene, const Mesh& mesh, unsigned triangle, float u, float v, glm::vec3 ray_direction);

/// Whether the material's alpha at this point lies under its cut-off.
bool is_cut_out(const Scene& scene, const Mesh& mesh, unsigned triangle, float u, float v);

}  // namespace dualpixel::simulator
