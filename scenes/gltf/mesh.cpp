#include "scenes/gltf/mesh.h"

#include <glm/gtc/matrix_inverse.hpp>

namespace dualpixel::scenes {

void Mesh::add_quad(glm::vec3 corner, glm::vec3 a, glm::vec3 b, glm::vec2 repeat) {
  const auto first = static_cast<unsigned>(positions.size());
  for (const glm::vec3& p : {corner, corner + a, corner + a + b, corner + b}) positions.push_back(p);
  for (const glm::vec2& uv : {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)}) {
    uvs.push_back(uv * repeat);
  }
  triangles.push_back({first, first + 1, first + 2});
  triangles.push_back({first, first + 2, first + 3});
}

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<unsigned>(mesh.positions.size());
  const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  add(mesh.positions, other.positions);
  add(mesh.normals, other.normals);
  add(mesh.uvs, other.uvs);
  for (const glm::uvec3& t : other.triangles) mesh.triangles.push_back(t + first);
}

Mesh placed_mesh(Mesh mesh, const glm::mat4& pose) {
  const glm::mat3 of_normals = glm::inverseTranspose(glm::mat3(pose));
  for (glm::vec3& p : mesh.positions) p = glm::vec3(pose * glm::vec4(p, 1));
  for (glm::vec3& n : mesh.normals) n = glm::normalize(of_normals * n);
  return mesh;
}

void drop_flat_triangles(Mesh& mesh) {
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
    const glm::dvec3 p(mesh.positions[t.x]);
    const glm::dvec3 n = glm::cross(glm::dvec3(mesh.positions[t.y]) - p, glm::dvec3(mesh.positions[t.z]) - p);
    return glm::dot(n, n) < 1e-24;
  });
}

}  // namespace dualpixel::scenes
