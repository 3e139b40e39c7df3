#include "simulator/render/surface.h"

#include <array>
#include <cmath>

namespace dualpixel::simulator {
namespace {

/// sRGB decoding (IEC 61966-2-1) of bytes, and the plain scaling of linear ones.
struct DecodeTables {
  std::array<float, 256> srgb;
  std::array<float, 256> linear;
  DecodeTables() {
    for (int i = 0; i < 256; ++i) {
      const double x = i / 255.0;
      linear[i] = static_cast<float>(x);
      srgb[i] = static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
    }
  }
};
const DecodeTables kDecode;

int wrap(int i, int size, Wrap mode) {
  if (static_cast<unsigned>(i) < static_cast<unsigned>(size)) return i;
  switch (mode) {
    case Wrap::clamp:
      return i < 0 ? 0 : size - 1;
    case Wrap::mirror: {
      const int period = 2 * size;
      const int m = ((i % period) + period) % period;
      return m < size ? m : period - 1 - m;
    }
    case Wrap::repeat:
      break;
  }
  return ((i % size) + size) % size;
}

template <typename T>
T interpolate(const std::vector<T>& values, const glm::uvec3& triangle, float u, float v) {
  return (1 - u - v) * values[triangle.x] + u * values[triangle.y] + v * values[triangle.z];
}

const std::vector<glm::vec2>& uv_set(const Mesh& mesh, const TextureSlot& slot) {
  return slot.uv_set == 0 ? mesh.uv0 : mesh.uv1;
}

/// The slot's texture at a point; `absent` where there is no texture or the mesh has no such UV set.
glm::vec4 sample_slot(const Scene& scene, const Mesh& mesh, const TextureSlot& slot, const glm::uvec3& triangle,
                      float u, float v, glm::vec4 absent = glm::vec4(1)) {
  if (slot.texture < 0) return absent;
  const auto& uvs = uv_set(mesh, slot);
  if (uvs.empty()) return absent;
  const glm::vec2 uv = interpolate(uvs, triangle, u, v);
  const auto& m = slot.uv_from_uv;
  return sample_texture(scene.textures[slot.texture],
                        {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]});
}

/// The shading normal bent by a tangent-space normal map; the tangent follows the texture's u direction on this
/// triangle (glTF 2.0, section 3.9.3, without authored tangents).
glm::vec3 mapped_normal(const Scene& scene, const Mesh& mesh, const Material& material, const glm::uvec3& t, float u,
                        float v, glm::vec3 normal) {
  const auto& uvs = uv_set(mesh, material.normal_texture);
  if (uvs.empty()) return normal;
  const glm::vec3 e1 = mesh.positions[t.y] - mesh.positions[t.x];
  const glm::vec3 e2 = mesh.positions[t.z] - mesh.positions[t.x];
  const glm::vec2 d1 = uvs[t.y] - uvs[t.x];
  const glm::vec2 d2 = uvs[t.z] - uvs[t.x];
  const float determinant = d1.x * d2.y - d2.x * d1.y;
  if (determinant == 0) return normal;
  glm::vec3 tangent = (e1 * d2.y - e2 * d1.y) / determinant;
  tangent -= normal * glm::dot(normal, tangent);
  const float length = glm::length(tangent);
  if (!(length > 0)) return normal;
  tangent /= length;
  const glm::vec3 bitangent = glm::cross(normal, tangent) * (determinant < 0 ? -1.0f : 1.0f);
  const glm::vec4 texel = sample_slot(scene, mesh, material.normal_texture, t, u, v, {0.5f, 0.5f, 1, 1});
  const glm::vec3 n = {(texel.x * 2 - 1) * material.normal_scale, (texel.y * 2 - 1) * material.normal_scale,
                       texel.z * 2 - 1};
  // v grows downwards in glTF's images while normal maps have +Y up
  return glm::normalize(tangent * n.x - bitangent * n.y + normal * n.z);
}

}  // namespace

glm::vec4 sample_texture(const Texture& texture, glm::vec2 uv) {
  const auto& decode = texture.srgb ? kDecode.srgb : kDecode.linear;
  const auto texel = [&](int x, int y) {
    const std::uint8_t* t = &texture.rgba[4 * (static_cast<std::size_t>(y) * texture.width + x)];
    return glm::vec4(decode[t[0]], decode[t[1]], decode[t[2]], kDecode.linear[t[3]]);
  };
  // Far-away UVs lose their fraction in float; repeat them within reach of int.
  const float x = (std::abs(uv.x) < 1e4f ? uv.x : 0) * texture.width;
  const float y = (std::abs(uv.y) < 1e4f ? uv.y : 0) * texture.height;
  if (texture.nearest) {
    return texel(wrap(static_cast<int>(std::floor(x)), texture.width, texture.wrap_u),
                 wrap(static_cast<int>(std::floor(y)), texture.height, texture.wrap_v));
  }
  const float left = std::floor(x - 0.5f);
  const float top = std::floor(y - 0.5f);
  const float fx = x - 0.5f - left;
  const float fy = y - 0.5f - top;
  const int x0 = wrap(static_cast<int>(left), texture.width, texture.wrap_u);
  const int x1 = wrap(static_cast<int>(left) + 1, texture.width, texture.wrap_u);
  const int y0 = wrap(static_cast<int>(top), texture.height, texture.wrap_v);
  const int y1 = wrap(static_cast<int>(top) + 1, texture.height, texture.wrap_v);
  return (texel(x0, y0) * (1 - fx) + texel(x1, y0) * fx) * (1 - fy) +
         (texel(x0, y1) * (1 - fx) + texel(x1, y1) * fx) * fy;
}

Surface surface_at(const Scene& scene, const Mesh& mesh, unsigned triangle_index, float u, float v,
                   glm::vec3 ray_direction) {
  const glm::uvec3& t = mesh.triangles[triangle_index];
  const Material& material = scene.materials[mesh.material];
  Surface s;
  const glm::vec3 p0 = mesh.positions[t.x];
  const glm::vec3 e1 = mesh.positions[t.y] - p0;
  const glm::vec3 e2 = mesh.positions[t.z] - p0;
  s.position = p0 + u * e1 + v * e2;
  s.geometric_normal = glm::normalize(glm::cross(e1, e2));
  s.normal = s.geometric_normal;
  if (!mesh.normals.empty()) {
    const glm::vec3 n = interpolate(mesh.normals, t, u, v);
    const float squared = glm::dot(n, n);
    if (squared > 1e-12f) s.normal = n / std::sqrt(squared);
  }
  if (material.normal_texture.texture >= 0) s.normal = mapped_normal(scene, mesh, material, t, u, v, s.normal);
  if (glm::dot(s.geometric_normal, ray_direction) > 0) s.geometric_normal = -s.geometric_normal;
  if (glm::dot(s.normal, s.geometric_normal) < 0) s.normal = -s.normal;

  glm::vec4 base = material.base_color * sample_slot(scene, mesh, material.base_color_texture, t, u, v);
  if (!mesh.colors.empty()) base *= interpolate(mesh.colors, t, u, v);
  s.base_color = glm::vec3(base);
  s.alpha = base.w;
  s.unlit = material.unlit;
  s.metallic = material.metallic;
  s.roughness = material.roughness;
  if (material.metallic_roughness_texture.texture >= 0) {
    const glm::vec4 texel = sample_slot(scene, mesh, material.metallic_roughness_texture, t, u, v);
    s.roughness *= texel.y;
    s.metallic *= texel.z;
  }
  s.emission_nits = material.emission_nits;
  if (material.emissive_texture.texture >= 0) {
    s.emission_nits *= glm::vec3(sample_slot(scene, mesh, material.emissive_texture, t, u, v));
  }
  return s;
}

bool is_cut_out(const Scene& scene, const Mesh& mesh, unsigned triangle_index, float u, float v) {
  const glm::uvec3& t = mesh.triangles[triangle_index];
  const Material& material = scene.materials[mesh.material];
  float alpha = material.base_color.w * sample_slot(scene, mesh, material.base_color_texture, t, u, v).w;
  if (!mesh.colors.empty()) alpha *= interpolate(mesh.colors, t, u, v).w;
  return alpha < material.alpha_cutoff;
}

}  // namespace dualpixel::simulator
