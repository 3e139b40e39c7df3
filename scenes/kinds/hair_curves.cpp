#include "scenes/kinds/hair_curves.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scenes/people/shape/reflectance.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

constexpr float kStrandsPerM2 = 300000, kWidth_m = 0.00022f;
constexpr float kMostStrands = 40000;

/// The vertices of a mesh by cells of space.
class NearestVertex {
 public:
  explicit NearestVertex(const std::vector<vec3>& positions) {
    vec3 low = positions.front(), high = low;
    for (const vec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
    first_ = cell_of(low) - 2;  // two empty cells around: points in the outer one have no vertex near
    size_ = cell_of(high) - first_ + 3;
    starts_.resize(static_cast<std::size_t>(size_.x) * size_.y * size_.z + 1);
    for (const vec3& p : positions) ++starts_[index(cell_of(p)) + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    vertices_.resize(positions.size());
    std::vector<unsigned> next = starts_;
    for (unsigned i = 0; i < positions.size(); ++i) vertices_[next[index(cell_of(positions[i]))]++] = {positions[i], i};
  }

  /// -1: none within a cell's side.
  int operator()(vec3 p) const {
    const glm::ivec3 cell = cell_of(p), in = cell - first_;
    if (glm::any(glm::lessThan(in, glm::ivec3(1))) || glm::any(glm::greaterThan(in, size_ - 2))) return -1;
    float nearest = kCell_m * kCell_m;
    int found = -1;
    for (int row = 0; row < 9; ++row) {  // of three cells
      const std::size_t middle = index(cell + glm::ivec3(0, row % 3 - 1, row / 3 - 1));
      for (unsigned k = starts_[middle - 1]; k < starts_[middle + 2]; ++k) {
        const vec3 way = vertices_[k].position - p;
        if (const float d = glm::dot(way, way); d < nearest) nearest = d, found = static_cast<int>(vertices_[k].index);
      }
    }
    return found;
  }

 private:
  static constexpr float kCell_m = 0.012f;
  struct Vertex {
    vec3 position;
    unsigned index;
  };
  static glm::ivec3 cell_of(vec3 p) { return {glm::floor(p / kCell_m)}; }
  std::size_t index(glm::ivec3 cell) const {
    const glm::ivec3 in = cell - first_;
    return (static_cast<std::size_t>(in.z) * size_.y + in.y) * size_.x + in.x;
  }
  glm::ivec3 first_, size_;
  std::vector<unsigned> starts_;  ///< of each cell's vertices
  std::vector<Vertex> vertices_;  ///< by cells
};

/// Which way hair lies at a point of the mass: away from the crown and down, in locks.
vec3 combed(const Figure& figure, std::uint32_t seed, vec3 p, vec3 n) {
  const vec3 crown = figure.skeleton.head.to_world(figure.body.head_scale * vec3(0.02f, 0.16f, -0.05f));
  const vec3 lock(noise(seed, p * 30.0f) - 0.5f, noise(seed + 1, p * 30.0f) - 0.5f, noise(seed + 2, p * 30.0f) - 0.5f);
  const vec3 wanted = glm::normalize(p - crown + vec3(0, 0.001f, 0)) + vec3(0, -0.8f, 0) + 0.9f * lock;
  return wanted - n * glm::dot(wanted, n);
}

/// Where a strand starts and how it goes from there.
struct Root {
  vec3 position, normal, color;
  float length_m, lift_m;
  vec3 own_direction;
};

std::vector<Root> draw_roots(const SceneObject& mass, const Material& material, RandomStream& rng) {
  std::vector<float> area{0};
  for (const glm::uvec3& t : mass.triangles) {
    const vec3 a = mass.positions[t.y] - mass.positions[t.x], b = mass.positions[t.z] - mass.positions[t.x];
    area.push_back(area.back() + 0.5f * glm::length(glm::cross(a, b)));
  }
  if (!(area.back() > 0)) return {};
  std::vector<Root> roots(static_cast<std::size_t>(std::min(kStrandsPerM2 * area.back(), kMostStrands)));
  for (Root& root : roots) {
    const auto above = std::upper_bound(area.begin() + 1, area.end(), area.back() * rng.uniform());
    const auto triangle = static_cast<std::size_t>(std::min(above, area.end() - 1) - area.begin() - 1);
    const glm::uvec3 t = mass.triangles[triangle];
    float u = rng.uniform(), v = rng.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto at_root = [&](const std::vector<vec3>& values) {
      return (1 - u - v) * values[t.x] + u * values[t.y] + v * values[t.z];
    };
    root.position = at_root(mass.positions);
    root.normal = glm::normalize(at_root(mass.normals));
    root.color = glm::clamp(reflectance(material, at_root(mass.rest)) * rng.uniform(0.7f, 1.35f), vec3(0), vec3(1));
    const bool stray = rng.chance(0.02f);
    root.length_m = mass.hair_m * rng.uniform(0.5f, 1.4f);
    root.lift_m = 0.0008f + 0.004f * rng.uniform() * rng.uniform() + (stray ? 0.2f * root.length_m : 0.0f);
    root.own_direction = (stray ? 0.8f : 0.35f) * rng.uniform3(-1, 1);
  }
  return roots;
}

}  // namespace

HairCurves grow_hair(const SceneObject& mass, const Material& material, const Figure& figure, RandomStream rng) {
  constexpr unsigned kSegments = 6, kPoints = kSegments + 1;
  const std::uint32_t seed = rng.seed();
  const std::vector<Root> roots = draw_roots(mass, material, rng);
  HairCurves hair;
  if (roots.empty()) return hair;
  const NearestVertex nearest(mass.positions);
  hair.points.resize(kPoints * roots.size());
  hair.colors.resize(hair.points.size());
  hair.widths_m.resize(hair.points.size());
  hair.segments.resize(kSegments * roots.size());
  tbb::parallel_for(std::size_t{0}, roots.size(), [&](std::size_t i) {
    const Root& root = roots[i];
    vec3 p = root.position, n = root.normal;
    for (unsigned s = 0; s <= kSegments; ++s) {
      const std::size_t point = kPoints * i + s;
      const float along = static_cast<float>(s) / kSegments;
      hair.points[point] = p;
      hair.colors[point] = root.color;
      hair.widths_m[point] = kWidth_m * (1 - 0.7f * along * along);
      if (s == kSegments) break;
      hair.segments[kSegments * i + s] = glm::uvec2(point, point + 1);
      const vec3 direction = combed(figure, seed, p, n) + root.own_direction - n * glm::dot(root.own_direction, n);
      p += root.length_m / kSegments * glm::normalize(direction + vec3(0, -1e-4f, 0));
      const int beside = nearest(p);
      if (beside < 0) continue;
      n = mass.normals[static_cast<std::size_t>(beside)];
      p += (root.lift_m * (along + 0.3f) - glm::dot(p - mass.positions[static_cast<std::size_t>(beside)], n)) * n;
    }
  });
  return hair;
}

}  // namespace dualpixel::scenes
