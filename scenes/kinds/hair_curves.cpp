#include "scenes/kinds/hair_curves.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "scenes/people/shape/reflectance.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

constexpr float kStrandsPerM2 = 300000, kWidth_m = 0.00022f;
constexpr int kMostStrands = 40000;

/// The vertices of a mesh by cells of space.
class NearestVertex {
 public:
  explicit NearestVertex(const std::vector<vec3>& positions) : positions_(positions) {
    for (unsigned i = 0; i < positions.size(); ++i)
      cells_[key(glm::ivec3(glm::floor(positions[i] / kCell_m)))].push_back(i);
  }

  /// -1: none within a cell's side.
  int operator()(vec3 p) const {
    const glm::ivec3 middle(glm::floor(p / kCell_m));
    float nearest = kCell_m * kCell_m;
    int found = -1;
    for (int k = 0; k < 27; ++k) {
      const auto cell = cells_.find(key(middle + glm::ivec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
      if (cell == cells_.end()) continue;
      for (const unsigned i : cell->second) {
        const vec3 way = positions_[i] - p;
        if (const float d = glm::dot(way, way); d < nearest) nearest = d, found = static_cast<int>(i);
      }
    }
    return found;
  }

 private:
  static constexpr float kCell_m = 0.012f;
  static std::int64_t key(glm::ivec3 cell) {
    return (static_cast<std::int64_t>(cell.x) * 4001 + cell.y) * 4001 + cell.z;
  }
  const std::vector<vec3>& positions_;
  std::unordered_map<std::int64_t, std::vector<unsigned>> cells_;
};

/// Which way hair lies at a point of the mass: away from the crown and down, in locks.
vec3 combed(const Figure& figure, std::uint32_t seed, vec3 p, vec3 n) {
  const vec3 crown = figure.skeleton.head.to_world(figure.body.head_scale * vec3(0.02f, 0.16f, -0.05f));
  const vec3 lock(noise(seed, p * 30.0f) - 0.5f, noise(seed + 1, p * 30.0f) - 0.5f, noise(seed + 2, p * 30.0f) - 0.5f);
  const vec3 wanted = glm::normalize(p - crown + vec3(0, 0.001f, 0)) + vec3(0, -0.8f, 0) + 0.9f * lock;
  return wanted - n * glm::dot(wanted, n);
}

}  // namespace

HairCurves grow_hair(const SceneObject& mass, const Material& material, const Figure& figure, RandomStream rng) {
  constexpr int kSegments = 6;
  HairCurves hair;
  std::vector<float> area{0};
  for (const glm::uvec3& t : mass.triangles) {
    const vec3 a = mass.positions[t.y] - mass.positions[t.x], b = mass.positions[t.z] - mass.positions[t.x];
    area.push_back(area.back() + 0.5f * glm::length(glm::cross(a, b)));
  }
  const NearestVertex nearest(mass.positions);
  const std::uint32_t seed = rng.seed();
  const int strands = std::min(static_cast<int>(kStrandsPerM2 * area.back()), kMostStrands);
  for (int i = 0; i < strands; ++i) {
    const auto above = std::upper_bound(area.begin() + 1, area.end(), area.back() * rng.uniform());
    const auto triangle = static_cast<std::size_t>(std::min(above, area.end() - 1) - area.begin() - 1);
    const glm::uvec3 t = mass.triangles[triangle];
    float u = rng.uniform(), v = rng.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto at_root = [&](const std::vector<vec3>& values) {
      return (1 - u - v) * values[t.x] + u * values[t.y] + v * values[t.z];
    };
    vec3 p = at_root(mass.positions), n = glm::normalize(at_root(mass.normals));
    const vec3 color = reflectance(material, at_root(mass.rest)) * rng.uniform(0.7f, 1.35f);
    const bool stray = rng.chance(0.02f);
    const float length_m = mass.hair_m * rng.uniform(0.5f, 1.4f), step_m = length_m / kSegments;
    const float lift_m = 0.0008f + 0.004f * rng.uniform() * rng.uniform() + (stray ? 0.2f * length_m : 0.0f);
    const vec3 own = (stray ? 0.8f : 0.35f) * rng.uniform3(-1, 1);
    const auto first = static_cast<unsigned>(hair.points.size());
    for (int s = 0; s <= kSegments; ++s) {
      const float along = static_cast<float>(s) / kSegments;
      hair.points.push_back(p);
      hair.colors.push_back(glm::clamp(color, vec3(0), vec3(1)));
      hair.widths_m.push_back(kWidth_m * (1 - 0.7f * along * along));
      if (s > 0) hair.segments.emplace_back(first + s - 1, first + s);
      const vec3 direction = combed(figure, seed, p, n) + own - n * glm::dot(own, n);
      p += step_m * glm::normalize(direction + vec3(0, -1e-4f, 0));
      const int beside = nearest(p);
      if (beside < 0) continue;
      n = mass.normals[static_cast<std::size_t>(beside)];
      p += (lift_m * (along + 0.3f) - glm::dot(p - mass.positions[static_cast<std::size_t>(beside)], n)) * n;
    }
  }
  return hair;
}

}  // namespace dualpixel::scenes
