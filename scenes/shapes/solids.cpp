#include "scenes/shapes/solids.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/math.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

unsigned add_vertex(Mesh& mesh, vec3 p, vec3 n, vec2 uv) {
  mesh.positions.push_back(p);
  mesh.normals.push_back(n);
  mesh.uvs.push_back(uv);
  return static_cast<unsigned>(mesh.positions.size()) - 1;
}

void add_quad_faces(Mesh& mesh, unsigned a, unsigned b, unsigned c, unsigned d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

/// Joins `rows` + 1 rings of `columns` + 1 vertices each that begin at `first`.
void join_grid(Mesh& mesh, unsigned first, int columns, int rows) {
  const auto stride = static_cast<unsigned>(columns) + 1;
  for (unsigned i = 0; i < static_cast<unsigned>(rows); ++i) {
    for (unsigned j = 0; j + 1 < stride; ++j) {
      const unsigned a = first + i * stride + j;
      add_quad_faces(mesh, a, a + 1, a + stride + 1, a + stride);
    }
  }
}

vec3 unit_or(vec3 v, vec3 otherwise) {
  const float length = glm::length(v);
  return length > 1e-12f ? v / length : otherwise;
}

}  // namespace

void add_solid_box(Mesh& mesh, vec3 center, vec3 half, float edge_m, const glm::mat3& axes) {
  unsigned corner[3][8];  // by the axis of the face that it belongs to, and the octant
  for (int axis = 0; axis < 3; ++axis) {
    for (int octant = 0; octant < 8; ++octant) {
      vec3 sign, p;
      for (int k = 0; k < 3; ++k) {
        sign[k] = (octant >> k & 1) != 0 ? 1.0f : -1.0f;
        p[k] = sign[k] * (half[k] - (k == axis ? 0 : edge_m));
      }
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const vec3 n = axes[axis] * sign[axis];
      // the top's u runs along x, walls' v downwards
      const vec2 uv = axis == 1 ? vec2(p.x, p.z) : axis == 0 ? vec2(p.z, -p.y) : vec2(p.x, -p.y);
      corner[axis][octant] = add_vertex(mesh, center + axes * p, n, uv + vec2(half[u], half[v]));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3), w = 1 << axis;
    for (const int side : {0, w}) {
      add_quad_faces(mesh, corner[axis][side], corner[axis][side | u], corner[axis][side | u | v],
                     corner[axis][side | v]);
    }
    if (edge_m <= 0) continue;
    const int other = (axis + 1) % 3;  // rounded edges between these two kinds of face run along the third axis
    for (const int at : {0, w, u, w | u}) {
      add_quad_faces(mesh, corner[axis][at], corner[axis][at | v], corner[other][at | v], corner[other][at]);
    }
  }
  for (int octant = 0; octant < 8 && edge_m > 0; ++octant) {
    mesh.triangles.push_back({corner[0][octant], corner[1][octant], corner[2][octant]});
  }
}

void add_lathe(Mesh& mesh, const glm::mat4& pose, const std::vector<vec2>& profile, int sides) {
  const float kSharp = std::cos(35 * kPi / 180);
  const int segments = static_cast<int>(profile.size()) - 1;
  std::vector<vec2> normal(static_cast<std::size_t>(segments));
  float widest = 0;
  for (int i = 0; i < segments; ++i) {
    const vec2 along = profile[i + 1] - profile[i];
    const float length = glm::length(along);
    normal[i] = length > 0 ? vec2(along.y, -along.x) / length : vec2(1, 0);
    widest = std::max({widest, profile[i].x, profile[i + 1].x});
  }
  const glm::mat3 turn(pose);
  float way = 0;
  for (int i = 0; i < segments; ++i) {
    const auto shared = [&](int other) {
      if (other < 0 || other >= segments || glm::dot(normal[i], normal[other]) < kSharp) return normal[i];
      return glm::normalize(normal[i] + normal[other]);
    };
    const vec2 ends[2] = {shared(i - 1), shared(i + 1)};
    const auto first = static_cast<unsigned>(mesh.positions.size());
    for (int end = 0; end < 2; ++end) {
      const vec2 p = profile[i + end], n = ends[end];
      if (end == 1) way += glm::length(profile[i + 1] - profile[i]);
      for (int s = 0; s <= sides; ++s) {
        const float phi = 2 * kPi * static_cast<float>(s % sides) / static_cast<float>(sides);
        const vec3 out(std::cos(phi), 0, std::sin(phi));
        add_vertex(mesh, vec3(pose * glm::vec4(p.x * out + vec3(0, p.y, 0), 1)),
                   glm::normalize(turn * (n.x * out + vec3(0, n.y, 0))),
                   {2 * kPi * widest * static_cast<float>(s) / static_cast<float>(sides), -way});
      }
    }
    join_grid(mesh, first, sides, 1);
  }
}

void add_ball(Mesh& mesh, vec3 center, vec3 radii, int rows, const std::function<float(vec3)>& bumps) {
  const int columns = 2 * rows;
  const auto point = [&](float u, float v) {
    const float theta = kPi * v, phi = 2 * kPi * u;
    const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    return center + radii * n * (bumps ? bumps(n) : 1.0f);
  };
  const auto first = static_cast<unsigned>(mesh.positions.size());
  const float girth = 2 * kPi * radii.x;
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const float u = static_cast<float>(j % columns) / static_cast<float>(columns);
      const float v = static_cast<float>(i) / static_cast<float>(rows);
      constexpr float kStep = 1e-3f;
      const float low = std::clamp(v - kStep, kStep, 1 - 3 * kStep);
      const vec3 p = i == 0 || i == rows ? center + vec3(0, (i == 0 ? 1.0f : -1.0f) * radii.y, 0) *
                                                        (bumps ? bumps(vec3(0, i == 0 ? 1 : -1, 0)) : 1.0f)
                                         : point(u, v);
      const vec3 n = glm::cross(point(u, low + 2 * kStep) - point(u, low),
                                point(u + kStep, low + kStep) - point(u - kStep, low + kStep));
      const vec3 outward = unit_or(-n, p - center);
      add_vertex(mesh, p, glm::dot(outward, p - center) < 0 ? -outward : outward,
                 {girth * static_cast<float>(j) / static_cast<float>(columns), kPi * radii.y * v});
    }
  }
  join_grid(mesh, first, columns, rows);
}

void add_pipe(Mesh& mesh, const std::vector<vec3>& path, const std::vector<float>& radii, int sides, bool closed_ends) {
  const auto count = static_cast<int>(path.size());
  const auto first = static_cast<unsigned>(mesh.positions.size());
  vec3 along = unit_or(path[1] - path[0], {0, 1, 0});
  vec3 x = glm::normalize(glm::cross(along, std::abs(along.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0)));
  float way = 0;
  for (int i = 0; i < count; ++i) {
    along = unit_or(path[std::min(i + 1, count - 1)] - path[std::max(i - 1, 0)], along);
    x = unit_or(x - glm::dot(x, along) * along, x);
    const vec3 y = glm::cross(along, x);
    if (i > 0) way += glm::distance(path[i], path[i - 1]);
    for (int s = 0; s <= sides; ++s) {
      const float phi = 2 * kPi * static_cast<float>(s % sides) / static_cast<float>(sides);
      const vec3 n = std::cos(phi) * x + std::sin(phi) * y;
      add_vertex(mesh, path[i] + radii[i] * n, n,
                 {2 * kPi * radii[0] * static_cast<float>(s) / static_cast<float>(sides), way});
    }
  }
  join_grid(mesh, first, sides, count - 1);
  for (const int end : {0, count - 1}) {
    if (!closed_ends || radii[end] <= 0) continue;
    const vec3 out =
        (end == 0 ? -1.0f : 1.0f) * unit_or(path[end == 0 ? 1 : end] - path[end == 0 ? 0 : end - 1], along);
    const unsigned ring = first + static_cast<unsigned>(end * (sides + 1));
    const unsigned tip = add_vertex(mesh, path[end], out, mesh.uvs[ring]);
    for (unsigned s = 0; s < static_cast<unsigned>(sides); ++s) mesh.triangles.push_back({tip, ring + s, ring + s + 1});
  }
}

void add_pipe(Mesh& mesh, const std::vector<vec3>& path, float radius, int sides) {
  add_pipe(mesh, path, std::vector<float>(path.size(), radius), sides);
}

void add_sheet(Mesh& mesh, int columns, int rows, vec2 size_m, const std::function<vec3(float, float)>& at) {
  const auto first = static_cast<unsigned>(mesh.positions.size());
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const vec2 uv(static_cast<float>(j) / static_cast<float>(columns),
                    static_cast<float>(i) / static_cast<float>(rows));
      add_vertex(mesh, at(uv.x, uv.y), vec3(0, 1, 0), uv * size_m);
    }
  }
  const auto vertex = [&](int i, int j) {
    return mesh
        .positions[first + static_cast<unsigned>(std::clamp(i, 0, rows) * (columns + 1) + std::clamp(j, 0, columns))];
  };
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      mesh.normals[first + static_cast<unsigned>(i * (columns + 1) + j)] =
          unit_or(glm::cross(vertex(i + 1, j) - vertex(i - 1, j), vertex(i, j + 1) - vertex(i, j - 1)), {0, 1, 0});
    }
  }
  join_grid(mesh, first, columns, rows);
}

std::vector<vec3> curve(int count, const std::function<vec3(float)>& at) {
  std::vector<vec3> points;
  for (int i = 0; i < count; ++i) points.push_back(at(static_cast<float>(i) / static_cast<float>(count - 1)));
  return points;
}

glm::mat4 standing(vec3 at, float angle) { return glm::rotate(glm::translate(glm::mat4(1), at), angle, vec3(0, 1, 0)); }

}  // namespace dualpixel::scenes
