#pragma once
#include <glm/glm.hpp>

#include "simulator/render/ray_packet.h"
#include "simulator/render/vec3_packet.h"
#include "simulator/scene/scene.h"

/// What rays find where they meet a mesh: interpolated attributes, textures looked up, material resolved.
namespace dualpixel::simulator {

/// A point on a triangle with glTF's metallic-roughness material (glTF 2.0, Appendix B). Both sides of a surface look
/// the same; normals point to the side that the ray came from.
struct Surface {
  glm::vec3 position{0};
  glm::vec3 geometric_normal{0, 0, 1};  ///< unit
  glm::vec3 normal{0, 0, 1};            ///< unit: interpolated, normal-mapped
  glm::vec3 base_color{0};
  float metallic = 0;
  float roughness = 1;
  const Layers* layers = nullptr;  ///< of the material; null: none
  bool hair = false;               ///< a strand: normals are only sides of it
  glm::vec3 tangent{0};            ///< unit, along the strand
  float across = 0;                ///< as in HairStrand
};

/// Sixteen of them, on one mesh.
struct SurfacePacket {
  Vec3Packet position, geometric_normal, normal, base_color, emission_nits;
  alignas(64) float metallic[kPacket], roughness[kPacket];
  alignas(64) float magnitude[kPacket];  ///< of the largest coordinate that rounding errors of `position` go by
  bool emits = false;                    ///< otherwise emission_nits is not filled in
  bool lambertian = false;  ///< metallic 0, roughness 1, no layers throughout; otherwise the former are filled in
  const Layers* layers = nullptr;  ///< of the mesh's material
  bool hair = false;               ///< strands; otherwise what follows is not filled in
  Vec3Packet tangent;
  alignas(64) float across[kPacket], radius_m[kPacket];

  Surface at(int i) const;
};

/// Bilinear (or nearest) lookup; linear RGB, alpha as stored. There are no mip levels. Of 8192 x 8192 texels,
/// four across a photosite, a sample of an unlit surface takes 55 ns, and 44 where a texel is as large as a photosite:
/// levels could save those 11 at most, and would average before the lens what the film averages after it.
glm::vec4 sample_texture(const Texture& texture, glm::vec2 uv);

/// The lanes of `rays` with lanes[i] != 0, at least one, all of which hit `mesh`; other lanes of `out` are finite but
/// mean nothing.
void surfaces_at(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays,
                 SurfacePacket& out);

/// base_color alone, which is all of an unlit surface.
void base_colors_at(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays,
                    Vec3Packet& out);

/// Unit, on the side from which a triangle's corners turn counter-clockwise. `hit` lies on `mesh`.
glm::vec3 outward_normal(const Mesh& mesh, const Hit& hit);

/// The same, or a side of a strand of hair, on the side that the ray came from.
glm::vec3 geometric_normal(const Mesh& mesh, const Hit& hit, glm::vec3 ray_direction);

/// Emitted radiance, nits. `u`, `v`: Embree's barycentrics, weights of the triangle's second and third vertex.
glm::vec3 emission_at(const Scene& scene, const Mesh& mesh, unsigned triangle, float u, float v);

/// Whether the material's alpha at this point lies under its cut-off.
bool is_cut_out(const Scene& scene, const Mesh& mesh, unsigned triangle, float u, float v);

}  // namespace dualpixel::simulator
