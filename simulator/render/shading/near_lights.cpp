#include "simulator/render/shading/near_lights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simulator/render/shading/pick.h"
#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

std::vector<NearLight> punctual_lights(const Scene& scene, glm::vec3 middle, float radius_squared) {
  std::vector<NearLight> lights;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& light = scene.lights[i];
    const float candela = luminance(light.intensity);
    if (light.kind == PunctualLight::Kind::directional || !(candela > 0)) continue;
    const glm::vec3 off = light.position - middle;
    const float distance_squared = std::max(radius_squared, glm::dot(off, off));  // a lamp far outside shines on little
    lights.push_back({i, light.position, light.position, candela, candela / (4 * distance_squared)});
  }
  return lights;
}

std::vector<NearLight> emissive_lights(const Scene& scene, const std::vector<NearLights::Triangle>& triangles,
                                       float radius_squared) {
  std::vector<NearLight> lights;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const NearLights::Triangle& t = triangles[i];
    if (!(t.area_m2 > 0)) continue;
    const glm::vec3 second = t.corner + t.first_edge, third = t.corner + t.second_edge;
    const float candela =
        luminance(scene.materials[scene.meshes[t.mesh].material].emission_nits) * t.area_m2 / 2;  // of both sides
    lights.push_back({scene.lights.size() + i, glm::min(glm::min(t.corner, second), third),
                      glm::max(glm::max(t.corner, second), third), candela, candela / (2 * radius_squared)});
  }
  return lights;
}

double lux_of(const std::vector<NearLight>& lights) {
  double sum = 0;  // in float a weak lamp would vanish beside strong ones
  for (const NearLight& light : lights) sum += light.average_lux;
  return sum;
}

/// A weak lamp is not to be lost beside a strong one, which may not shine where the weak one does.
void raise_weak(std::vector<NearLight>& hard, std::vector<NearLight>& soft) {
  constexpr double kLeast = 1e-2;
  const double glowing = lux_of(soft), all = lux_of(hard) + glowing;
  const auto least = static_cast<float>(kLeast * all / static_cast<double>(std::max<std::size_t>(hard.size(), 1)));
  for (NearLight& light : hard) light.average_lux = std::max(light.average_lux, least);
  if (!(glowing < kLeast * all)) return;
  for (NearLight& light : soft) light.average_lux *= static_cast<float>(kLeast * all / glowing);
}

/// Lux that a group would throw on a surface if nothing were in the way: of its mean side from its center, or from
/// its sphere's radius within it. The cosine is raised by the sphere's angular radius, so that this is 0 exactly where
/// all of the sphere is behind the surface.
inline float lux_on(const LightGroup& group, float x, float y, float z, float normal_x, float normal_y,
                    float normal_z) {
  constexpr float kLeast_m = 1e-6f;  // so that a light without extent has a weight where it stands
  const float to_x = group.center.x - x, to_y = group.center.y - y, to_z = group.center.z - z;
  const float distance = std::max(std::sqrt(to_x * to_x + to_y * to_y + to_z * to_z), kLeast_m);
  const float raised = (normal_x * to_x + normal_y * to_y + normal_z * to_z + group.radius_m) / distance;
  const float nearest = std::max(distance, group.radius_m);
  return group.candela * std::min(std::max(raised, 0.0f), 1.0f) / (nearest * nearest);
}

/// The share of samples that a group has: half by what it throws on the point, half by average light.
inline float share_of(float lux, float all_lux, float average_lux, float all_average_lux) {
  constexpr float kByAverage = 0.5f;
  return lux > 0 ? (1 - kByAverage) * lux / all_lux + kByAverage * average_lux / all_average_lux : 0.0f;
}

}  // namespace

NearLights::NearLights(const Scene& scene, glm::vec3 middle, float radius_m) {
  first_triangle_of_mesh_.assign(scene.meshes.size(), -1);
  for (unsigned m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const Material& material = scene.materials[mesh.material];
    if (luminance(material.emission_nits) <= 0 || material.unlit || mesh.is_hair()) continue;
    first_triangle_of_mesh_[m] = static_cast<int>(triangles_.size());
    for (unsigned t = 0; t < mesh.triangles.size(); ++t) {
      const glm::uvec3& corners = mesh.triangles[t];
      const glm::vec3 p = mesh.positions[corners.x];
      const glm::vec3 first_edge = mesh.positions[corners.y] - p, second_edge = mesh.positions[corners.z] - p;
      const glm::vec3 normal = glm::cross(first_edge, second_edge);
      triangles_.push_back({m, t, 0.5f * glm::length(normal), p, first_edge, second_edge, glm::normalize(normal)});
    }
  }
  const float radius_squared = std::max(radius_m * radius_m, 1e-12f);
  std::vector<NearLight> hard = punctual_lights(scene, middle, radius_squared);
  std::vector<NearLight> soft = emissive_lights(scene, triangles_, radius_squared);
  raise_weak(hard, soft);
  hard_lux_ = static_cast<float>(lux_of(hard)), soft_lux_ = static_cast<float>(lux_of(soft));
  places_.resize(triangles_.size());
  add_groups(hard, scene.lights.size());
  hard_groups_ = groups_.size();
  add_groups(soft, scene.lights.size());
}

void NearLights::add_groups(std::vector<NearLight>& lights, std::size_t first_triangle) {
  const std::size_t before = lights_.size();
  const std::vector<LightGroup> groups = group_lights(lights, kMostGroups);
  lights_.resize(before + lights.size());
  sums_.resize(before + lights.size());
  for (LightGroup group : groups) {
    double sum = 0;
    for (std::size_t i = group.first; i < group.end; ++i) {
      lights_[before + i] = lights[i].index;
      sums_[before + i] = static_cast<float>(sum += lights[i].average_lux);
    }
    group.first += before, group.end += before;
    normalize_sums(sums_.begin() + static_cast<std::ptrdiff_t>(group.first),
                   sums_.begin() + static_cast<std::ptrdiff_t>(group.end));
    for (std::size_t i = group.first; i < group.end; ++i) {
      if (lights_[i] < first_triangle) continue;
      const float below = i > group.first ? sums_[i - 1] : 0;
      places_[lights_[i] - first_triangle] = {groups_.size(), sums_[i] - below};
    }
    groups_.push_back(group);
  }
}

NearLights::Sums NearLights::sums_at(glm::vec3 point, glm::vec3 normal, LightKinds kinds) const {
  Sums sums;
  for (std::size_t k = first_group(kinds); k < end_group(kinds); ++k) {
    const float lux = lux_on(groups_[k], point.x, point.y, point.z, normal.x, normal.y, normal.z);
    sums.lux += lux;
    sums.average_lux += lux > 0 ? groups_[k].average_lux : 0;
  }
  return sums;
}

void NearLights::choose(const Vec3Packet& point, const Vec3Packet& normal, LightKinds kinds, Choice& out) const {
  alignas(64) float all_lux[kPacket] = {}, all_average[kPacket] = {};
  for (std::size_t k = first_group(kinds); k < end_group(kinds); ++k) {
    const LightGroup group = groups_[k];
    float(&lux)[kPacket] = out.shares[k];
#pragma GCC ivdep
    for (int i = 0; i < kPacket; ++i) {
      lux[i] = lux_on(group, point.x[i], point.y[i], point.z[i], normal.x[i], normal.y[i], normal.z[i]);
      all_lux[i] += lux[i];
      all_average[i] += lux[i] > 0 ? group.average_lux : 0.0f;
    }
  }
  for (std::size_t k = first_group(kinds); k < end_group(kinds); ++k) {
    const float average_lux = groups_[k].average_lux;
    float(&shares)[kPacket] = out.shares[k];
#pragma GCC ivdep
    for (int i = 0; i < kPacket; ++i) shares[i] = share_of(shares[i], all_lux[i], average_lux, all_average[i]);
  }
  std::copy_n(all_lux, kPacket, out.lux);
}

NearLights::Picked NearLights::pick(const Choice& choice, int lane, LightKinds kinds, float& u) const {
  std::size_t chosen = first_group(kinds);
  float below = 0, with = 0;
  for (std::size_t k = chosen; k < end_group(kinds); ++k) {
    if (!(choice.shares[k][lane] > 0)) continue;
    chosen = k;
    below = with, with += choice.shares[k][lane];
    if (u < with) break;  // else, by rounding, the last one
  }
  const LightGroup& group = groups_[chosen];
  const float share_of_group = choice.shares[chosen][lane];
  u = std::clamp((u - below) / share_of_group, 0.0f, 0x1.fffffep-1f);
  float share;
  const std::size_t entry = pick_from(&sums_[group.first], group.end - group.first, u, share);
  return {lights_[group.first + entry], share_of_group * share};
}

float NearLights::probability(glm::vec3 point, glm::vec3 normal, LightKinds kinds, int triangle) const {
  const Place& place = places_[triangle];
  const LightGroup& group = groups_[place.group];
  const float lux = lux_on(group, point.x, point.y, point.z, normal.x, normal.y, normal.z);
  if (!(lux > 0)) return 0;
  const Sums all = sums_at(point, normal, kinds);
  return place.share * share_of(lux, all.lux, group.average_lux, all.average_lux);
}

}  // namespace dualpixel::simulator
