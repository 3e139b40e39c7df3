#include "simulator/scene/scale.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace dualpixel::simulator {
namespace {

/// Each point once. A strand's segment has two.
std::vector<glm::vec3> used_points(const Mesh& mesh) {
  std::vector<bool> used(mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) {
    used[t.x] = used[t.y] = true;
    if (!mesh.is_hair()) used[t.z] = true;
  }
  std::vector<glm::vec3> points;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) points.push_back(mesh.positions[i]);
  }
  return points;
}

}  // namespace

float longest_side(const Scene& scene) {
  constexpr float kFar = std::numeric_limits<float>::max();
  glm::vec3 low(kFar), high(-kFar);
  const auto add = [&](const glm::vec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  };
  for (const Mesh& mesh : scene.meshes) {
    const std::vector<glm::vec3> points = used_points(mesh);
    if (mesh.placements.empty()) std::for_each(points.begin(), points.end(), add);
    for (const Placement& placement : mesh.placements) {
      for (const glm::vec3& p : points) add(placement.world_from_mesh * glm::vec4(p, 1));
    }
  }
  const glm::vec3 sides = high - low;
  return std::max({sides.x, sides.y, sides.z, 0.0f});
}

void scale_to(Scene& scene, double longest_m) {
  const float longest = longest_side(scene);
  if (longest <= 0) return;
  const auto factor = static_cast<float>(longest_m / longest);
  for (Mesh& mesh : scene.meshes) {
    if (mesh.placements.empty()) {
      for (glm::vec3& p : mesh.positions) p *= factor;
      for (float& radius : mesh.radii) radius *= factor;
    }
    for (Placement& placement : mesh.placements) placement.world_from_mesh *= factor;
  }
  for (Material& material : scene.materials) {
    if (material.layers) material.layers->absorption_per_m /= factor;
  }
  for (PunctualLight& light : scene.lights) {
    light.position *= factor;
    light.range_m *= factor;
    if (light.kind != PunctualLight::Kind::directional) light.intensity *= factor * factor;
  }
  for (CameraNode& camera : scene.cameras) {
    for (int i = 0; i < 3; ++i) camera.world_from_node[3][i] *= factor;
  }
}

}  // namespace dualpixel::simulator
