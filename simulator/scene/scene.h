#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// A scene as plain arrays: what a glTF file becomes before Embree sees it. Everything here has been checked: indices
/// are in range, values are finite, node transforms are applied, but for those of meshes that several nodes share.
/// Lengths are meters in glTF's world axes (y up); light is photometric: radiance in nits (cd/m^2) for each of linear
/// R, G, B (Rec. 709 primaries).
namespace dualpixel::simulator {

enum class Wrap : std::uint8_t { repeat, clamp, mirror };

/// 8-bit RGBA texels, rows from top to bottom (v = 0 is the top row, as glTF has it).
struct Texture {
  int width = 0;
  int height = 0;
  bool srgb = false;     ///< RGB are sRGB encoded (alpha never is)
  bool nearest = false;  ///< no bilinear filtering
  Wrap wrap_u = Wrap::repeat;
  Wrap wrap_v = Wrap::repeat;
  std::vector<std::uint8_t> rgba;               ///< empty where `paged` holds them
  std::shared_ptr<const std::uint8_t[]> paged;  ///< where textures outgrow memory: see paged_bytes()
  std::vector<glm::vec4> decoded;  ///< the same as linear numbers, where it is small: see keep_decoded(); else empty

  std::span<const std::uint8_t> bytes() const {
    return paged ? std::span(paged.get(), std::size_t{4} * width * height) : std::span(rgba);
  }
};

/// Fills `decoded` of a texture of up to 2048 x 2048 texels: four times the memory, a sixth off an unlit sample.
void keep_decoded(Texture& texture);

/// The same of each, as long as half a gigabyte holds them.
void keep_decoded(std::vector<Texture>& textures);

/// Linear values of bytes: sRGB ones (IEC 61966-2-1), and linear ones.
struct DecodeTables {
  std::array<float, 256> srgb, linear;
};
extern const DecodeTables kDecodeTables;

/// One texel as linear numbers. Not for static initializers, which may run before the tables are filled.
inline glm::vec4 decode_texel(const Texture& texture, std::size_t index) {
  const auto& color = texture.srgb ? kDecodeTables.srgb : kDecodeTables.linear;
  const std::uint8_t* t = (texture.paged ? texture.paged.get() : texture.rgba.data()) + 4 * index;
  return {color[t[0]], color[t[1]], color[t[2]], kDecodeTables.linear[t[3]]};
}

/// A texture as one material slot uses it; KHR_texture_transform is folded into the affine map uv' = m * (u, v, 1).
struct TextureSlot {
  int texture = -1;                                      ///< index into Scene::textures, -1: none
  int uv_set = 0;                                        ///< 0 or 1
  std::array<float, 6> uv_from_uv = {1, 0, 0, 0, 1, 0};  ///< row-major 2x3
};

/// What glTF's extensions of the metallic-roughness material add: KHR_materials_ior, _specular, _clearcoat, _sheen,
/// _transmission and _volume. The same all over the material.
struct Layers {
  float ior = 1.5f;             ///< at least 1, or 0: head-on it reflects specular_color, and bends light as 1.5 does
  float specular = 1;           ///< of the dielectric's reflection, at all angles
  glm::vec3 specular_color{1};  ///< of the same, head-on
  float clearcoat = 0;          ///< share of the surface under a coat of ior 1.5
  float clearcoat_roughness = 0;
  glm::vec3 sheen_color{0};
  float sheen_roughness = 0;
  float transmission = 0;         ///< share of light that enters and passes, instead of being diffuse; 0 of what emits
  bool solid = false;             ///< the mesh encloses its glass; otherwise it is a thin pane
  glm::vec3 absorption_per_m{0};  ///< of solid glass
  float subsurface = 0;           ///< share of what is diffuse that comes from a deep layer, as of skin: see layers.h
};

struct Material {
  glm::vec4 base_color{1};
  float metallic = 1;
  float roughness = 1;
  glm::vec3 emission_nits{0};  ///< factor times KHR_materials_emissive_strength
  float normal_scale = 1;
  float alpha_cutoff = 0;  ///< hits with alpha below it are passed through; 0: opaque
  bool double_sided = false;
  bool unlit = false;  ///< radiance is base color times Scene::unlit_white_nits
  TextureSlot base_color_texture;
  TextureSlot metallic_roughness_texture;  ///< G roughness, B metallic
  TextureSlot emissive_texture;
  TextureSlot normal_texture;
  std::optional<Layers> layers;  ///< empty: none of them

  /// Lets light pass.
  bool is_glass() const { return layers && layers->transmission > 0 && !unlit; }
};

/// One instance of a shared mesh.
struct Placement {
  glm::mat4x3 world_from_mesh{1};  ///< invertible; may mirror
  std::uint32_t object_id = 0;     ///< as a Mesh's
  bool person = false;
};

/// One primitive of one node, in world space, or, with placements, of several nodes, in coordinates of its own. Arrays
/// other than positions and placements are empty or have one entry per vertex.
struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  ///< unit length; empty: flat shading
  std::vector<glm::vec2> uv0;
  std::vector<glm::vec2> uv1;
  std::vector<glm::vec4> colors;  ///< linear, multiplies the base color
  std::vector<glm::uvec3> triangles;
  /// Not empty: strands of hair in world space, with the radius at each vertex, m. Their segments stand in for
  /// triangles: from corner x to corner y; z repeats x.
  std::vector<float> radii;
  int material = 0;             ///< index into Scene::materials
  std::uint32_t object_id = 0;  ///< 1-based index of the glTF node
  bool person = false;          ///< node or an ancestor has extras {"category": "person"}
  /// Not empty: the mesh appears once per placement and nowhere else, with the placement's object and person. Such a
  /// mesh must not emit: light is sampled from triangles in world space.
  std::vector<Placement> placements;

  bool is_hair() const { return !radii.empty(); }
};

/// KHR_lights_punctual, in world space.
struct PunctualLight {
  enum class Kind : std::uint8_t { point, spot, directional } kind = Kind::point;
  glm::vec3 intensity{0};  ///< candela for point and spot, lux for directional; each of R, G, B
  glm::vec3 position{0};
  glm::vec3 direction{0, 0, -1};  ///< unit, the way the light travels
  float range_m = 0;              ///< 0: unlimited
  float cos_inner_cone = 1;
  float cos_outer_cone = 0.70710678f;
};

/// Light from infinity: an equirectangular picture in nits. Row 0 is straight up (+y); the middle column is -z, and u
/// grows towards +x. Empty: black.
struct Environment {
  int width = 0;
  int height = 0;
  std::vector<glm::vec3> radiance_nits;
};

/// A camera node: pose and, where the file gives it, the vertical field of view.
struct CameraNode {
  std::string name;
  glm::mat4 world_from_node{1};  ///< glTF's camera looks along its own -z, y up; rigid
  std::optional<float> vertical_fov_rad;
};

struct Scene {
  std::vector<Texture> textures;
  std::vector<Material> materials;  ///< at least one
  std::vector<Mesh> meshes;
  std::vector<PunctualLight> lights;
  std::vector<CameraNode> cameras;
  Environment environment;
  float unlit_white_nits = 100;
  std::vector<std::string> object_names;  ///< object_names[object_id - 1] is the node's name
  std::string source_hash;                ///< of the bytes of the glTF file and of all that it names
  std::vector<std::string> warnings;      ///< one line each: zero-area triangles left out, features ignored, ...
};

/// Whether light passes the mesh's surface.
inline bool is_glass(const Scene& scene, const Mesh& mesh) {
  return !mesh.is_hair() && scene.materials[mesh.material].is_glass();
}

}  // namespace dualpixel::simulator
