#include "simulator/render/light/bright_surfaces.h"

#include <algorithm>
#include <cmath>

#include "simulator/render/shading/lights.h"
#include "simulator/render/shading/pick.h"
#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

/// A light of some extent, as it looks from further away.
struct Lamp {
  glm::vec3 center{0};
  float radius_m = 0;
  float candela = 0;
  unsigned mesh = kNoMesh;  ///< that emits; kNoMesh: a punctual light
};

Lamp lamp_of(const Scene& scene, unsigned mesh_id) {
  const Mesh& mesh = scene.meshes[mesh_id];
  Lamp lamp;
  lamp.mesh = mesh_id;
  float area = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const float piece = 0.5f * glm::length(glm::cross(b - a, c - a));
    lamp.center += piece * (a + b + c) / 3.0f;
    area += piece;
  }
  lamp.center /= std::max(area, 1e-20f);
  for (const glm::vec3& p : mesh.positions) lamp.radius_m = std::max(lamp.radius_m, glm::length(p - lamp.center));
  lamp.candela = luminance(scene.materials[mesh.material].emission_nits) * area / 4;
  return lamp;
}

std::vector<Lamp> lamps_of(const Scene& scene) {
  std::vector<Lamp> lamps;
  for (const PunctualLight& light : scene.lights) {
    if (light.kind == PunctualLight::Kind::directional) continue;
    lamps.push_back({light.position, 0, luminance(light.intensity)});
  }
  for (unsigned m = 0; m < scene.meshes.size(); ++m) {
    const Material& material = scene.materials[scene.meshes[m].material];
    if (luminance(material.emission_nits) > 0 && !material.unlit) lamps.push_back(lamp_of(scene, m));
  }
  return lamps;
}

/// Illuminance on either side of a surface of this normal, lux.
float lux_of(const Lamp& lamp, const Intersector& intersector, glm::vec3 point, glm::vec3 normal, float least_lux) {
  const glm::vec3 to_lamp = lamp.center - point;
  const float distance = glm::length(to_lamp);
  if (!(distance > 1.01f * lamp.radius_m)) return 0;
  const float cosine = glm::dot(normal, to_lamp) / distance;
  const float lux = lamp.candela * std::abs(cosine) / (distance * distance);
  if (!(lux > least_lux)) return 0;
  const glm::vec3 start = point + 1e-4f * distance * (cosine < 0 ? -normal : normal);
  const auto hit = intersector.intersect(Ray{start, to_lamp / distance});
  return hit && hit->t < distance - 1.01f * lamp.radius_m ? 0 : lux;
}

}  // namespace

BrightSurfaces::BrightSurfaces(const Scene& scene, const Lights& lights, const Intersector& intersector)
    : index_(scene.meshes.size()) {
  constexpr float kBright = 10;         // times the light on the average surface that faces lamps
  constexpr float kLeastShare = 0.01f;  // less is found by chance as well
  const std::vector<Lamp> lamps = lamps_of(scene);
  const auto lux_at = [&](const Triangle& triangle, unsigned mesh) {
    const glm::vec3 middle = triangle.corner + (triangle.first_edge + triangle.second_edge) / 3.0f;
    float lux = 0;
    for (const Lamp& lamp : lamps) {
      if (lamp.mesh == mesh) continue;
      lux += lux_of(lamp, intersector, middle, triangle.normal, kBright * lights.near_lux());
    }
    return lux;
  };
  float lumens = 0;
  for (unsigned m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const Material& material = scene.materials[mesh.material];
    if (material.unlit || material.is_glass() || mesh.is_hair() || !mesh.placements.empty()) continue;
    // Light samples of a surface that glows would have to know whether glass lies on their way.
    if (luminance(material.emission_nits) > 0 && intersector.has_glass()) continue;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::optional<Triangle> triangle = triangle_of(mesh, mesh.triangles[t]);
      const float lux = triangle ? lux_at(*triangle, m) : 0;
      if (!(lux > 0)) continue;
      if (index_[m].empty()) index_[m].assign(mesh.triangles.size(), -1);
      index_[m][t] = static_cast<int>(triangles_.size());
      triangles_.push_back(*triangle);
      lumens += lux * triangle->area_m2;
      shares_.push_back(lumens);
    }
  }
  if (triangles_.empty()) return;
  normalize_sums(shares_.begin(), shares_.end());
  float all_lumens = 0;
  for (const Lamp& lamp : lamps) all_lumens += 4 * kPi * lamp.candela;
  share_ = std::min(0.5f, lumens / all_lumens) * lights.near_share();
  if (share_ < kLeastShare) share_ = 0;
}

std::optional<BrightSurfaces::Triangle> BrightSurfaces::triangle_of(const Mesh& mesh, const glm::uvec3& corners) {
  const glm::vec3 p = mesh.positions[corners.x];
  Triangle triangle{p, mesh.positions[corners.y] - p, mesh.positions[corners.z] - p};
  const glm::vec3 normal = glm::cross(triangle.first_edge, triangle.second_edge);
  triangle.area_m2 = 0.5f * glm::length(normal);
  if (!(triangle.area_m2 > 0)) return {};
  triangle.normal = normal / (2 * triangle.area_m2);
  return triangle;
}

BrightSurfaces::Target BrightSurfaces::towards(glm::vec3 point, float u, float v) const {
  float share;
  const std::size_t entry = pick_from(shares_.data(), shares_.size(), u, share);
  const Triangle& triangle = triangles_[entry];
  const float half = 0.5f * std::min(u, v);  // uniform over the triangle (Heitz 2019, low distortion)
  const glm::vec3 at = triangle.corner + (u - half) * triangle.first_edge + (v - half) * triangle.second_edge - point;
  const float length = glm::length(at);
  if (!(length > 0)) return {};
  return {at / length, static_cast<int>(entry)};
}

float BrightSurfaces::pdf(int triangle, glm::vec3 direction, float distance_m) const {
  const Triangle& t = triangles_[triangle];
  const float cosine = std::abs(glm::dot(t.normal, direction));
  if (!(cosine > 1e-6f)) return 0;
  const float share = shares_[triangle] - (triangle > 0 ? shares_[triangle - 1] : 0);
  return share * distance_m * distance_m / (cosine * t.area_m2);
}

}  // namespace dualpixel::simulator
