#include "simulator/render/shading/near_lights.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulator/render/shading/pick.h"
#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Adds it if it gives any light; renders take numbers below the normal ones for 0. On surfaces that face it the mean
/// cosine is a half.
void add_source(std::size_t index, glm::vec3 low, glm::vec3 high, float candela, float distance_squared,
                std::vector<LightSource>& lights) {
  const float average_lux = candela / (2 * distance_squared);
  if (average_lux >= std::numeric_limits<float>::min()) lights.push_back({index, low, high, candela, average_lux});
}

std::vector<LightSource> punctual_sources(const Scene& scene, glm::vec3 middle, float radius_squared) {
  std::vector<LightSource> lights;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& light = scene.lights[i];
    if (light.kind == PunctualLight::Kind::directional) continue;
    const glm::vec3 off = light.position - middle;
    const float distance_squared = std::max(radius_squared, glm::dot(off, off));  // a lamp far outside lights little
    add_source(i, light.position, light.position, luminance(light.intensity), distance_squared, lights);
  }
  return lights;
}

std::vector<LightSource> emissive_sources(const Scene& scene, const std::vector<NearLights::Triangle>& triangles,
                                          float radius_squared) {
  std::vector<LightSource> lights;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const NearLights::Triangle& t = triangles[i];
    const glm::vec3 second = t.corner + t.first_edge, third = t.corner + t.second_edge;
    const float candela = luminance(scene.materials[scene.meshes[t.mesh].material].emission_nits) * t.area_m2 / 2;
    add_source(scene.lights.size() + i, glm::min(glm::min(t.corner, second), third),
               glm::max(glm::max(t.corner, second), third), candela, radius_squared, lights);
  }
  return lights;
}

double average_lux_of(const std::vector<LightSource>& lights) {
  double sum = 0;  // in float a weak lamp would vanish beside strong ones
  for (const LightSource& light : lights) sum += light.average_lux;
  return sum;
}

/// A weak lamp is not to be lost beside a strong one, which may be hidden where the weak one is not.
void raise_weak(std::vector<LightSource>& hard, std::vector<LightSource>& soft) {
  constexpr double kLeast = 1e-2;
  const double of_soft = average_lux_of(soft), all = average_lux_of(hard) + of_soft;
  const auto least = static_cast<float>(kLeast * all / static_cast<double>(std::max<std::size_t>(hard.size(), 1)));
  for (LightSource& light : hard) light.average_lux = std::max(light.average_lux, least);
  if (soft.empty() || of_soft >= kLeast * all) return;
  const double factor = kLeast * all / of_soft;
  for (LightSource& light : soft) light.average_lux = static_cast<float>(light.average_lux * factor);
}

/// Estimate of a group's illuminance on a surface: from its center, or from its sphere's radius within it. The cosine
/// is raised by the sine of the sphere's angular radius, so that the estimate is 0 only where all of it is behind the
/// surface.
inline float lux_on(const LightGroup& group, float x, float y, float z, float normal_x, float normal_y,
                    float normal_z) {
  constexpr float kLeast_m = 1e-6f;  // nothing is divided by 0
  const float to_x = group.center.x - x, to_y = group.center.y - y, to_z = group.center.z - z;
  const float distance = std::max(std::sqrt(to_x * to_x + to_y * to_y + to_z * to_z), kLeast_m);
  const float raised = (normal_x * to_x + normal_y * to_y + normal_z * to_z + group.radius_m) / distance;
  const float nearest = std::max(distance, group.radius_m);
  return group.candela * std::min(std::max(raised, 0.0f), 1.0f) / (nearest * nearest);
}

/// The share of samples that a group has: half by its estimate, half by average light.
inline float mixed_share(float lux, float all_lux, float average_lux, float all_average_lux) {
  constexpr float kByAverage = 0.5f;
  return lux > 0 ? (1 - kByAverage) * lux / all_lux + kByAverage * average_lux / all_average_lux : 0.0f;
}

}  // namespace

NearLights::NearLights(const Scene& scene, const Intersector::Bounds& bounds) {
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
  const glm::vec3 size = bounds.high - bounds.low;
  glm::vec3 middle = 0.5f * (bounds.high + bounds.low);
  float radius_squared = std::max(0.25f * glm::dot(size, size), 1e-12f);
  if (!(radius_squared < kInfinity)) middle = glm::vec3(0), radius_squared = 1;  // nothing is there to be lit
  std::vector<LightSource> hard = punctual_sources(scene, middle, radius_squared);
  std::vector<LightSource> soft = emissive_sources(scene, triangles_, radius_squared);
  raise_weak(hard, soft);
  hard_lux_ = static_cast<float>(average_lux_of(hard)), soft_lux_ = static_cast<float>(average_lux_of(soft));
  places_.resize(triangles_.size());
  add_groups(hard, scene.lights.size());
  hard_groups_ = groups_.size();
  add_groups(soft, scene.lights.size());
}

void NearLights::add_groups(std::vector<LightSource>& lights, std::size_t first_triangle) {
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

NearLights::Weights NearLights::weights(glm::vec3 point, glm::vec3 normal, LightKinds kinds) const {
  Weights all;
  for (std::size_t k = first_group(kinds); k < end_group(kinds); ++k) {
    const float lux = lux_on(groups_[k], point.x, point.y, point.z, normal.x, normal.y, normal.z);
    all.lux += lux;
    all.average_lux += lux > 0 ? groups_[k].average_lux : 0;
  }
  return all;
}

void NearLights::choose(const Vec3Packet& point, const Vec3Packet& normal, LightKinds kinds, Choice& out) const {
  out.first_group = first_group(kinds), out.end_group = end_group(kinds);
  alignas(64) float all_lux[kPacket] = {}, all_average[kPacket] = {};
  for (std::size_t k = out.first_group; k < out.end_group; ++k) {
    const LightGroup group = groups_[k];
    float(&lux)[kPacket] = out.shares[k];
#pragma GCC ivdep
    for (int i = 0; i < kPacket; ++i) {
      lux[i] = lux_on(group, point.x[i], point.y[i], point.z[i], normal.x[i], normal.y[i], normal.z[i]);
      all_lux[i] += lux[i];
      all_average[i] += lux[i] > 0 ? group.average_lux : 0.0f;
    }
  }
  for (std::size_t k = out.first_group; k < out.end_group; ++k) {
    const float average_lux = groups_[k].average_lux;
    float(&shares)[kPacket] = out.shares[k];
#pragma GCC ivdep
    for (int i = 0; i < kPacket; ++i) shares[i] = mixed_share(shares[i], all_lux[i], average_lux, all_average[i]);
  }
  std::copy_n(all_lux, kPacket, out.lux);
}

NearLights::Picked NearLights::pick(const Choice& choice, int lane, float& u) const {
  std::size_t chosen = choice.first_group;
  float below = 0, with = 0;
  for (std::size_t k = choice.first_group; k < choice.end_group; ++k) {
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

float NearLights::probability(glm::vec3 point, glm::vec3 normal, const Weights& weights, int triangle) const {
  const Place& place = places_[triangle];
  if (!(place.share > 0)) return 0;
  const LightGroup& group = groups_[place.group];
  const float lux = lux_on(group, point.x, point.y, point.z, normal.x, normal.y, normal.z);
  return place.share * mixed_share(lux, weights.lux, group.average_lux, weights.average_lux);
}

}  // namespace dualpixel::simulator
