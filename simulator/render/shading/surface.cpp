#include "simulator/render/shading/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "simulator/render/shading/hair.h"

namespace dualpixel::simulator {
namespace {

/// Where a bilinear lookup reads along one side of a picture: texels `low` and `high`, `high` by `fraction`.
struct Tap {
  int low, high;
  float fraction;
};

/// For any `u`, NaN included, without branches: loops over lanes become vector instructions.
inline Tap linear_tap(float u, int size, Wrap mode) {
  const bool repeat = mode == Wrap::repeat;
  const float period = repeat ? 1.0f : 2.0f, per_period = 1 / period;
  u = mode == Wrap::clamp ? u : u - period * std::floor(u * per_period);
  u = mode == Wrap::mirror && u > 1 ? 2 - u : u;
  u = u < 1 ? u : 1.0f;                                                  // also where it is NaN
  const float x = (u > 0 ? u : 0.0f) * static_cast<float>(size) + 0.5f;  // from the texel before the first
  const int low = static_cast<int>(x) - 1, high = low + 1, last = size - 1;
  const int below = repeat ? last : 0, above = repeat ? 0 : last;
  return {low >= 0 ? low : below, high <= last ? high : above, x - static_cast<float>(low + 1)};
}

/// The texel that u lies in.
inline Tap nearest_tap(float u, int size, Wrap mode) {
  const Tap t = linear_tap(u, size, mode);
  const int texel = t.fraction >= 0.5f ? t.high : t.low;
  return {texel, texel, 0};
}

struct TapPacket {
  alignas(64) int low[kPacket], high[kPacket];
  alignas(64) float fraction[kPacket];
  Tap at(int i) const { return {low[i], high[i], fraction[i]}; }
};

void taps(const float u[kPacket], int size, Wrap mode, bool nearest, TapPacket& out) {
  for (int i = 0; i < kPacket; ++i) {
    const Tap t = linear_tap(u[i], size, mode);
    out.low[i] = t.low, out.high[i] = t.high, out.fraction[i] = t.fraction;
  }
  if (!nearest) return;
  for (int i = 0; i < kPacket; ++i) {
    const Tap t = nearest_tap(u[i], size, mode);
    out.low[i] = t.low, out.high[i] = t.high, out.fraction[i] = t.fraction;
  }
}

using Vec4 = float __attribute__((vector_size(16)));

template <class Texel>
Vec4 blend(const Texel& texel, const Tap& x, const Tap& y) {
  const Vec4 upper = texel(x.low, y.low) * (1 - x.fraction) + texel(x.high, y.low) * x.fraction;
  const Vec4 lower = texel(x.low, y.high) * (1 - x.fraction) + texel(x.high, y.high) * x.fraction;
  return upper * (1 - y.fraction) + lower * y.fraction;
}

inline Vec4 texels_at(const Texture& texture, const Tap& x, const Tap& y) {
  const auto index = [&](int column, int row) { return static_cast<std::size_t>(row) * texture.width + column; };
  if (!texture.decoded.empty()) {
    return blend(
        [&](int column, int row) {
          Vec4 texel;
          std::memcpy(&texel, &texture.decoded[index(column, row)], sizeof texel);
          return texel;
        },
        x, y);
  }
  return blend(
      [&](int column, int row) {
        const glm::vec4 t = decode_texel(texture, index(column, row));
        return Vec4{t.x, t.y, t.z, t.w};
      },
      x, y);
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

/// What a placement does to directions.
struct Axes {
  glm::mat3 edges;    ///< to the world from the mesh
  glm::mat3 normals;  ///< the same, of normals, but for their length: cofactors, which a mirror turns inside out
  bool mirror;
};

Axes axes_of(const Placement& placement) {
  const glm::mat3 m(placement.world_from_mesh);
  const glm::mat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  const bool mirror = glm::dot(m[0], cofactors[0]) < 0;
  return {m, mirror ? -cofactors : cofactors, mirror};
}

/// The shading normal bent by a tangent-space normal map; the tangent follows the texture's u direction on this
/// triangle (glTF 2.0, section 3.9.3, without authored tangents), as KHR_texture_transform turns it. `axes`: of the
/// placement, nullptr where there is none.
glm::vec3 mapped_normal(const Scene& scene, const Mesh& mesh, const Axes* axes, const Material& material,
                        const glm::uvec3& t, float u, float v, glm::vec3 normal) {
  const auto& uvs = uv_set(mesh, material.normal_texture);
  if (uvs.empty()) return normal;
  const glm::vec3 e1 = mesh.positions[t.y] - mesh.positions[t.x];
  const glm::vec3 e2 = mesh.positions[t.z] - mesh.positions[t.x];
  const auto& m = material.normal_texture.uv_from_uv;
  const auto turned = [&m](glm::vec2 d) { return glm::vec2(m[0] * d.x + m[1] * d.y, m[3] * d.x + m[4] * d.y); };
  const glm::vec2 d1 = turned(uvs[t.y] - uvs[t.x]), d2 = turned(uvs[t.z] - uvs[t.x]);
  const float determinant = d1.x * d2.y - d2.x * d1.y;
  if (determinant == 0) return normal;
  glm::vec3 tangent = (e1 * d2.y - e2 * d1.y) / determinant;
  if (axes) tangent = axes->edges * tangent;
  tangent -= normal * glm::dot(normal, tangent);
  const float length = glm::length(tangent);
  if (!(length > 0)) return normal;
  tangent /= length;
  const bool left_handed = (determinant < 0) != (axes && axes->mirror);
  const glm::vec3 bitangent = glm::cross(normal, tangent) * (left_handed ? -1.0f : 1.0f);
  const glm::vec4 texel = sample_slot(scene, mesh, material.normal_texture, t, u, v, {0.5f, 0.5f, 1, 1});
  const glm::vec3 n = {(texel.x * 2 - 1) * material.normal_scale, (texel.y * 2 - 1) * material.normal_scale,
                       texel.z * 2 - 1};
  // v grows downwards in glTF's images while normal maps have +Y up
  return glm::normalize(tangent * n.x - bitangent * n.y + normal * n.z);
}

}  // namespace

glm::vec4 sample_texture(const Texture& texture, glm::vec2 uv) {
  const auto tap = texture.nearest ? nearest_tap : linear_tap;
  const Vec4 t =
      texels_at(texture, tap(uv.x, texture.width, texture.wrap_u), tap(uv.y, texture.height, texture.wrap_v));
  return {t[0], t[1], t[2], t[3]};
}

namespace {

/// The corner indices of each lane's triangle; inactive lanes repeat an active one.
struct TrianglePacket {
  glm::uvec3 corners[kPacket];
  bool one = true;  ///< the same in all lanes
};

TrianglePacket triangles_of(const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays) {
  int first = 0;
  while (!lanes[first]) ++first;
  const unsigned first_id = rays.triangle[first];
  TrianglePacket t;
  for (int i = 0; i < kPacket; ++i) {
    const unsigned id = lanes[i] ? rays.triangle[i] : first_id;
    t.one = t.one && id == first_id;
    t.corners[i] = mesh.triangles[id];
  }
  return t;
}

/// One attribute of the three corners, in lanes.
struct Corners {
  Vec3Packet first{}, second{}, third{};

  Corners(const std::vector<glm::vec3>& values, const TrianglePacket& t) {
    for (int i = 0; i < (t.one ? 1 : kPacket); ++i) {
      first.set(i, values[t.corners[i].x]);
      second.set(i, values[t.corners[i].y]);
      third.set(i, values[t.corners[i].z]);
    }
    if (!t.one) return;
    for (Vec3Packet* p : {&first, &second, &third}) {
      for (int i = 1; i < kPacket; ++i) p->x[i] = p->x[0], p->y[i] = p->y[0], p->z[i] = p->z[0];
    }
  }
};

/// Where the slot's texture is to be looked up; false where there is none.
bool texture_coordinates(const Mesh& mesh, const TextureSlot& slot, const TrianglePacket& t, const RayPacket& rays,
                         float out_u[kPacket], float out_v[kPacket]) {
  if (slot.texture < 0) return false;
  const auto& uvs = uv_set(mesh, slot);
  if (uvs.empty()) return false;
  const std::array<float, 6> m = slot.uv_from_uv;
  alignas(64) float u[3][kPacket], v[3][kPacket];
  for (int corner = 0; corner < 3; ++corner) {
    const glm::vec2 first = uvs[t.corners[0][corner]];
    for (int i = 0; i < kPacket; ++i) u[corner][i] = first.x, v[corner][i] = first.y;
    for (int i = 1; !t.one && i < kPacket; ++i) {
      const glm::vec2 uv = uvs[t.corners[i][corner]];
      u[corner][i] = uv.x, v[corner][i] = uv.y;
    }
  }
#pragma GCC ivdep
  for (int i = 0; i < kPacket; ++i) {
    const float b1 = rays.u[i], b2 = rays.v[i], b0 = 1 - b1 - b2;
    const float x = b0 * u[0][i] + b1 * u[1][i] + b2 * u[2][i], y = b0 * v[0][i] + b1 * v[1][i] + b2 * v[2][i];
    out_u[i] = m[0] * x + m[1] * y + m[2];
    out_v[i] = m[3] * x + m[4] * y + m[5];
  }
  return true;
}

void base_colors_at(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const TrianglePacket& t,
                    const RayPacket& rays, Vec3Packet& out) {
  const Material& material = scene.materials[mesh.material];
  for (int i = 0; i < kPacket; ++i) out.set(i, glm::vec3(material.base_color));
  alignas(64) float u[kPacket], v[kPacket];
  if (texture_coordinates(mesh, material.base_color_texture, t, rays, u, v)) {
    const Texture& texture = scene.textures[material.base_color_texture.texture];
    TapPacket x, y;
    taps(u, texture.width, texture.wrap_u, texture.nearest, x);
    taps(v, texture.height, texture.wrap_v, texture.nearest, y);
    for (int i = 0; i < kPacket; ++i) {
      const Vec4 texel = texels_at(texture, x.at(i), y.at(i));
      out.x[i] *= texel[0], out.y[i] *= texel[1], out.z[i] *= texel[2];
    }
  }
  if (mesh.colors.empty()) return;
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    out.set(i, out.at(i) * glm::vec3(interpolate(mesh.colors, t.corners[i], rays.u[i], rays.v[i])));
  }
}

/// Carries lanes from a shared mesh's own coordinates to the world's.
struct Placing {
  Axes axes[kPacket];  ///< of the lanes that are wanted
  const int* lanes;

  Placing(const Mesh& mesh, const int wanted[kPacket], const RayPacket& rays) : lanes(wanted) {
    for (int i = 0; i < kPacket; ++i) {
      if (lanes[i]) axes[i] = axes_of(mesh.placements[rays.placement[i]]);
    }
  }
  void move(const Mesh& mesh, const RayPacket& rays, SurfacePacket& s) const {
    for (int i = 0; i < kPacket; ++i) {
      if (!lanes[i]) continue;
      const glm::vec3 origin = mesh.placements[rays.placement[i]].world_from_mesh[3];
      s.position.set(i, axes[i].edges * s.position.at(i) + origin);
      s.magnitude[i] = std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
      const glm::vec3 n = glm::normalize(axes[i].normals * s.normal.at(i));
      const float facing = n.x * rays.direction_x[i] + n.y * rays.direction_y[i] + n.z * rays.direction_z[i];
      s.normal.set(i, n);
      s.geometric_normal.set(i, facing > 0 ? -n : n);
    }
  }
  void turn(Vec3Packet& normals) const {
    for (int i = 0; i < kPacket; ++i) {
      if (lanes[i]) normals.set(i, glm::normalize(axes[i].normals * normals.at(i)));
    }
  }
};

}  // namespace

Surface SurfacePacket::at(int i) const {
  if (hair) {
    return {position.at(i), geometric_normal.at(i), normal.at(i), base_color.at(i), 0, roughness[i], nullptr,
            true,           tangent.at(i),          across[i]};
  }
  return {position.at(i),
          geometric_normal.at(i),
          normal.at(i),
          base_color.at(i),
          lambertian ? 0.0f : metallic[i],
          lambertian ? 1.0f : roughness[i],
          layers};
}

void base_colors_at(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays,
                    Vec3Packet& out) {
  base_colors_at(scene, mesh, lanes, triangles_of(mesh, lanes, rays), rays, out);
}

namespace {

glm::vec3 side_of(glm::vec3 tangent, glm::vec3 to_eye) {
  const glm::vec3 flat = to_eye - glm::dot(to_eye, tangent) * tangent;
  const glm::vec3 any = glm::cross(tangent, std::abs(tangent.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0));
  return glm::normalize(glm::dot(flat, flat) > 1e-8f ? flat : any);
}

/// Position, sides and tangent where rays meet strands.
void strands_at(const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays, SurfacePacket& s) {
  s.hair = true;
  for (int i = 0; i < kPacket; ++i) {
    s.position.set(i, glm::vec3(0)), s.tangent.set(i, {1, 0, 0});
    s.normal.set(i, {0, 0, 1}), s.geometric_normal.set(i, {0, 0, 1});
    s.across[i] = s.radius_m[i] = s.magnitude[i] = 0;
    if (!lanes[i]) continue;
    const glm::uvec3 ends = mesh.triangles[rays.triangle[i]];
    const glm::vec3 start = mesh.positions[ends.x], along = mesh.positions[ends.y] - start;
    const glm::vec3 direction(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
    const glm::vec3 origin(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]);
    const glm::vec3 position = origin + rays.far[i] * direction;
    const glm::vec3 tangent = glm::normalize(along), to_eye = -glm::normalize(direction);
    const float radius = glm::mix(mesh.radii[ends.x], mesh.radii[ends.y], rays.u[i]);
    s.position.set(i, position), s.tangent.set(i, tangent);
    s.normal.set(i, side_of(tangent, to_eye)), s.geometric_normal.set(i, s.normal.at(i));
    s.across[i] = across_strand(tangent, to_eye, (position - start - rays.u[i] * along) / radius);
    s.radius_m[i] = radius;
    s.magnitude[i] = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  }
}

/// Position and normals where rays meet triangles.
void points_at(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const TrianglePacket& t,
               const RayPacket& rays, SurfacePacket& s) {
  const Material& material = scene.materials[mesh.material];
  const Corners p(mesh.positions, t);
  Vec3Packet &g = s.geometric_normal, &n = s.normal;
#pragma GCC ivdep
  for (int i = 0; i < kPacket; ++i) {
    const float u = rays.u[i], v = rays.v[i];
    const float ax = p.second.x[i] - p.first.x[i], bx = p.third.x[i] - p.first.x[i];
    const float ay = p.second.y[i] - p.first.y[i], by = p.third.y[i] - p.first.y[i];
    const float az = p.second.z[i] - p.first.z[i], bz = p.third.z[i] - p.first.z[i];
    s.position.x[i] = p.first.x[i] + u * ax + v * bx;
    s.position.y[i] = p.first.y[i] + u * ay + v * by;
    s.position.z[i] = p.first.z[i] + u * az + v * bz;
    const float nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
    const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
    const float facing = nx * rays.direction_x[i] + ny * rays.direction_y[i] + nz * rays.direction_z[i];
    const float scale = 1 / length, side = facing > 0 ? -scale : scale;
    n.x[i] = nx * scale, n.y[i] = ny * scale, n.z[i] = nz * scale;
    g.x[i] = nx * side, g.y[i] = ny * side, g.z[i] = nz * side;
    s.magnitude[i] = 0;
  }
  std::optional<Placing> placing;
  if (!mesh.placements.empty()) placing.emplace(mesh, lanes, rays).move(mesh, rays, s);
  for (int i = 0; i < kPacket; ++i) {
    const float x = std::abs(s.position.x[i]), y = std::abs(s.position.y[i]), z = std::abs(s.position.z[i]);
    s.magnitude[i] = std::max(std::max(x, y), std::max(z, s.magnitude[i]));
  }
  if (!mesh.normals.empty()) {
    Corners c(mesh.normals, t);
    if (placing) placing->turn(c.first), placing->turn(c.second), placing->turn(c.third);
    for (int i = 0; i < kPacket; ++i) {
      const float b1 = rays.u[i], b2 = rays.v[i], b0 = 1 - b1 - b2;
      const float x = b0 * c.first.x[i] + b1 * c.second.x[i] + b2 * c.third.x[i];
      const float y = b0 * c.first.y[i] + b1 * c.second.y[i] + b2 * c.third.y[i];
      const float z = b0 * c.first.z[i] + b1 * c.second.z[i] + b2 * c.third.z[i];
      const float squared = x * x + y * y + z * z;
      const float scale = 1 / std::sqrt(squared);
      const bool usable = squared > 1e-12f;
      n.x[i] = usable ? x * scale : n.x[i];
      n.y[i] = usable ? y * scale : n.y[i];
      n.z[i] = usable ? z * scale : n.z[i];
    }
  }
  if (material.normal_texture.texture >= 0) {
    for (int i = 0; i < kPacket; ++i) {
      if (!lanes[i]) continue;
      const Axes* axes = placing ? &placing->axes[i] : nullptr;
      n.set(i, mapped_normal(scene, mesh, axes, material, t.corners[i], rays.u[i], rays.v[i], n.at(i)));
    }
  }
  for (int i = 0; i < kPacket; ++i) {
    const float facing = n.x[i] * g.x[i] + n.y[i] * g.y[i] + n.z[i] * g.z[i];
    const float side = facing < 0 ? -1.0f : 1.0f;
    n.x[i] *= side, n.y[i] *= side, n.z[i] *= side;
  }
}

}  // namespace

void surfaces_at(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays,
                 SurfacePacket& s) {
  const Material& material = scene.materials[mesh.material];
  const TrianglePacket t = triangles_of(mesh, lanes, rays);
  if (mesh.is_hair()) {
    strands_at(mesh, lanes, rays, s);
  } else {
    points_at(scene, mesh, lanes, t, rays, s);
  }
  base_colors_at(scene, mesh, lanes, t, rays, s.base_color);

  const bool textured = material.metallic_roughness_texture.texture >= 0;
  s.layers = material.layers ? &*material.layers : nullptr;
  s.lambertian = material.metallic == 0 && material.roughness >= 1 && !textured && !s.layers && !s.hair;
  if (!s.lambertian) {
    for (int i = 0; i < kPacket; ++i) {
      s.metallic[i] = material.metallic;
      s.roughness[i] = material.roughness;
      if (!textured || !lanes[i]) continue;
      const glm::vec4 texel =
          sample_slot(scene, mesh, material.metallic_roughness_texture, t.corners[i], rays.u[i], rays.v[i]);
      s.roughness[i] *= texel.y;
      s.metallic[i] *= texel.z;
    }
  }
  s.emits = material.emission_nits != glm::vec3(0);
  if (s.emits) {
    for (int i = 0; i < kPacket; ++i) {
      if (lanes[i]) s.emission_nits.set(i, emission_at(scene, mesh, rays.triangle[i], rays.u[i], rays.v[i]));
    }
  }
}

glm::vec3 outward_normal(const Mesh& mesh, const Hit& hit) {
  const glm::uvec3& t = mesh.triangles[hit.triangle];
  const glm::vec3 p = mesh.positions[t.x];
  glm::vec3 n = glm::normalize(glm::cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p));
  if (!mesh.placements.empty()) n = glm::normalize(axes_of(mesh.placements[hit.placement]).normals * n);
  return n;
}

glm::vec3 geometric_normal(const Mesh& mesh, const Hit& hit, glm::vec3 ray_direction) {
  if (mesh.is_hair()) {
    const glm::uvec3 ends = mesh.triangles[hit.triangle];
    return side_of(glm::normalize(mesh.positions[ends.y] - mesh.positions[ends.x]), -glm::normalize(ray_direction));
  }
  const glm::vec3 n = outward_normal(mesh, hit);
  return glm::dot(n, ray_direction) > 0 ? -n : n;
}

glm::vec3 emission_at(const Scene& scene, const Mesh& mesh, unsigned triangle, float u, float v) {
  const Material& material = scene.materials[mesh.material];
  return material.emission_nits *
         glm::vec3(sample_slot(scene, mesh, material.emissive_texture, mesh.triangles[triangle], u, v));
}

bool is_cut_out(const Scene& scene, const Mesh& mesh, unsigned triangle_index, float u, float v) {
  const glm::uvec3& t = mesh.triangles[triangle_index];
  const Material& material = scene.materials[mesh.material];
  float alpha = material.base_color.w * sample_slot(scene, mesh, material.base_color_texture, t, u, v).w;
  if (!mesh.colors.empty()) alpha *= interpolate(mesh.colors, t, u, v).w;
  return alpha < material.alpha_cutoff;
}

}  // namespace dualpixel::simulator
