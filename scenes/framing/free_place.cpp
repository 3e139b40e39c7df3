#include "scenes/framing/free_place.h"

#include <cmath>
#include <numbers>

namespace dualpixel::scenes {
namespace {

/// Whether the ray leaves a solid where it hits: by the corners' normals where there are any, as files' windings often
/// err; otherwise by the winding.
bool is_back(const simulator::Mesh& mesh, const simulator::Hit& hit, glm::vec3 direction) {
  const glm::uvec3 t = mesh.triangles[hit.triangle];
  if (!mesh.placements.empty()) {
    direction = glm::inverse(glm::mat3(mesh.placements[hit.placement].world_from_mesh)) * direction;
  }
  const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
  const glm::vec3 normal =
      mesh.normals.empty() ? glm::cross(b - a, c - a) : mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
  return glm::dot(normal, direction) > 0;
}

/// No wall or thing right at the camera, no solid around it, and nothing just before it on the way to the middle.
bool is_free(const simulator::ReadyScene& ready, glm::vec3 position, glm::vec3 middle) {
  constexpr float kClearance = 0.1f, kFreeWay = 0.3f;  // of the distance to the middle
  const glm::vec3 way = middle - position;
  const float distance = glm::length(way);
  int hits = 0, backs = 0;
  for (int i = 0; i < 27; ++i) {
    const glm::vec3 direction(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (direction == glm::vec3(0)) continue;
    const auto hit = ready.world.intersector.intersect({position, glm::normalize(direction)});
    if (!hit) continue;
    if (hit->t < kClearance * distance) return false;
    ++hits;
    backs += is_back(ready.scene.meshes[hit->mesh], *hit, direction) ? 1 : 0;
  }
  if (2 * backs > hits) return false;  // most of what it sees is the inside of things
  const auto hit = ready.world.intersector.intersect({position, way / distance});
  return !hit || hit->t >= kFreeWay * distance;
}

}  // namespace

std::optional<glm::vec3> free_place(const simulator::ReadyScene& ready, glm::vec3 middle, const ShellPlace& wanted) {
  constexpr double kRadians = std::numbers::pi / 180, kGoldenAngle = 137.50776405003785;
  constexpr int kPlaces = 24;
  const double distance = wanted.distance_m, up = kRadians * wanted.elevation_deg;
  for (int i = 0; i < kPlaces; ++i) {
    const double around = kRadians * (wanted.azimuth_deg + i * kGoldenAngle);
    const glm::vec3 position = middle + glm::vec3(distance * std::cos(up) * std::sin(around), distance * std::sin(up),
                                                  distance * std::cos(up) * std::cos(around));
    if (is_free(ready, position, middle)) return position;
  }
  return std::nullopt;
}

}  // namespace dualpixel::scenes
