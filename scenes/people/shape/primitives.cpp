#include "scenes/people/shape/primitives.h"

#include <numbers>

namespace dualpixel::scenes {

void smooth_normals(SceneObject& object) {
  object.normals.assign(object.positions.size(), vec3(0));
  for (const glm::uvec3& t : object.triangles) {
    const vec3 a = object.positions[t.x];
    const vec3 n = glm::cross(object.positions[t.y] - a, object.positions[t.z] - a);
    for (int c = 0; c < 3; ++c) object.normals[t[c]] += n;
  }
  for (vec3& n : object.normals) {
    const float length = glm::length(n);
    n = length > 0 ? n / length : vec3(0, 1, 0);
  }
}

void add_quad(SceneObject& object, vec3 corner, vec3 a, vec3 b, vec3 rest_shift) {
  const auto first = static_cast<unsigned>(object.positions.size());
  const vec3 normal = glm::normalize(glm::cross(a, b));
  const vec3 along_a(glm::length(a), 0, 0), along_b(0, glm::length(b), 0);
  const vec3 positions[4] = {corner, corner + a, corner + a + b, corner + b};
  const vec3 rest[4] = {vec3(0), along_a, along_a + along_b, along_b};
  for (int i = 0; i < 4; ++i) {
    object.positions.push_back(positions[i]);
    object.rest.push_back(rest[i] + rest_shift);
    object.normals.push_back(normal);
  }
  object.triangles.emplace_back(first, first + 1, first + 2);
  object.triangles.emplace_back(first, first + 2, first + 3);
}

void add_box(SceneObject& object, vec3 center, const mat3& axes, vec3 half, vec3 rest_shift) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      // u runs sideways and v upwards on all sides but top and bottom
      const int u = axis == 0 ? 2 : 0, v = axis == 1 ? 2 : 1;
      const vec3 a = 2 * half[u] * axes[u], b = 2 * half[v] * axes[v];
      const vec3 corner = center + side * half[axis] * axes[axis] - 0.5f * (a + b);
      add_quad(object, corner, a, b, rest_shift + vec3(0.37f * static_cast<float>(axis), 0, 0));
    }
  }
}

void add_tube(SceneObject& object, const std::vector<vec3>& path, const std::vector<float>& radii, int sides) {
  const auto first = static_cast<unsigned>(object.positions.size());
  const auto columns = static_cast<unsigned>(sides) + 1;
  vec3 across(0);
  float along = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const vec3 step = path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0];
    const vec3 forward = glm::length(step) > 0 ? glm::normalize(step) : vec3(0, 1, 0);
    if (i == 0) across = std::abs(forward.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
    across = glm::normalize(across - forward * glm::dot(across, forward));
    const vec3 other = glm::cross(forward, across);
    if (i > 0) along += glm::distance(path[i], path[i - 1]);
    for (int s = 0; s <= sides; ++s) {
      const float turn = static_cast<float>(s) / static_cast<float>(sides) * 2 * std::numbers::pi_v<float>;
      const vec3 n = std::cos(turn) * across + std::sin(turn) * other;
      object.positions.push_back(path[i] + radii[i] * n);
      object.rest.emplace_back(radii[i] * turn, along, 0);
      object.normals.push_back(n);
    }
    if (i == 0) continue;
    for (unsigned s = 0; s + 1 < columns; ++s) {
      const unsigned a = first + static_cast<unsigned>(i - 1) * columns + s, b = a + columns;
      object.triangles.emplace_back(a, a + 1, b + 1);
      object.triangles.emplace_back(a, b + 1, b);
    }
  }
}

void add_ellipsoid(SceneObject& object, vec3 center, vec3 radii, const mat3& axes, int rows) {
  const auto first = static_cast<unsigned>(object.positions.size());
  const int columns = 2 * rows;
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const float theta = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rows);
      const float phi = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(columns);
      const vec3 d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      object.positions.push_back(center + axes * (radii * d));
      object.rest.push_back(d);
      object.normals.push_back(glm::normalize(axes * (d / radii)));
    }
  }
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const unsigned a = first + static_cast<unsigned>(i * (columns + 1) + j),
                     b = a + static_cast<unsigned>(columns) + 1;
      if (i + 1 < rows) object.triangles.emplace_back(a, b, b + 1);
      if (i > 0) object.triangles.emplace_back(a, b + 1, a + 1);
    }
  }
}

}  // namespace dualpixel::scenes
