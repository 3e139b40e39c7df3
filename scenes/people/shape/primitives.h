#pragma once
#include "scenes/people/shape/scene_model.h"
#include "scenes/procedural/surface_nets.h"

/// Meshes of simple shapes, appended to an object.
namespace dualpixel::scenes {

/// Normals from the triangles about each vertex, weighted by area.
void smooth_normals(SceneObject& object);

/// The six sides of a box with half sizes `half` in the frame `axes` about `center`; rest runs along each side.
void add_box(SceneObject& object, vec3 center, const mat3& axes, vec3 half, vec3 rest_shift = vec3(0));
/// A rectangle with the corners corner, corner + a, corner + a + b, corner + b; rest is (along a, along b, 0).
void add_quad(SceneObject& object, vec3 corner, vec3 a, vec3 b, vec3 rest_shift = vec3(0));
/// A tube along a path; rest is (around, along, 0). Open at ends where the radius is not 0.
void add_tube(SceneObject& object, const std::vector<vec3>& path, const std::vector<float>& radii, int sides = 8);
/// An ellipsoid; rest is the unit direction in the frame `axes`.
void add_ellipsoid(SceneObject& object, vec3 center, vec3 radii, const mat3& axes, int rows = 10);

/// The zero surface of `distance(p)` inside the box, on cells of `cell_m`. Blocks of cells that the surface cannot
/// cross are skipped. rest = position.
template <typename Distance>
SceneObject polygonize(const Distance& distance, vec3 low, vec3 high, float cell_m) {
  constexpr int kBlock = 6;
  DistanceGrid grid((glm::ivec3(glm::ceil((high - low) / cell_m)) / kBlock + 1) * kBlock);
  const glm::ivec3 n = grid.n;
  const auto point = [&](int x, int y, int z) { return low + cell_m * vec3(x, y, z); };
  std::vector<glm::ivec3> crossed;
  const float reach = 0.5f * kBlock * cell_m * 1.7320508f * 1.5f;  // 1.5: distances are not exact
  for (int z = 0; z < n.z; z += kBlock) {
    for (int y = 0; y < n.y; y += kBlock) {
      for (int x = 0; x < n.x; x += kBlock) {
        const float middle = distance(point(x, y, z) + 0.5f * (kBlock - 1) * cell_m);
        const bool near = std::abs(middle) < reach;
        if (near) crossed.emplace_back(x, y, z);
        for (int k = z; k < z + kBlock; ++k) {
          for (int j = y; j < y + kBlock; ++j) {
            for (int i = x; i < x + kBlock; ++i)
              grid.value[grid.index(i, j, k)] = near ? distance(point(i, j, k)) : middle;
          }
        }
      }
    }
  }
  const auto for_cells = [&](const auto& visit) {
    // cells that start one before a crossed block may be cut by its first points
    for (const glm::ivec3& b : crossed) {
      for (int z = std::max(b.z - 1, 0); z < std::min(b.z + kBlock, n.z - 1); ++z) {
        for (int y = std::max(b.y - 1, 0); y < std::min(b.y + kBlock, n.y - 1); ++y) {
          for (int x = std::max(b.x - 1, 0); x < std::min(b.x + kBlock, n.x - 1); ++x) visit(x, y, z);
        }
      }
    }
  };
  SceneObject object;
  const auto add_vertex = [&](glm::ivec3 cell, const float(&v)[8]) {
    vec3 sum(0);
    int crossings = 0;
    for (int a = 0; a < 8; ++a) {
      for (int axis = 0; axis < 3; ++axis) {
        const int b = a | (1 << axis);
        if (b == a || (v[a] < 0) == (v[b] < 0)) continue;
        vec3 at(a & 1, (a >> 1) & 1, a >> 2);
        at[axis] = v[a] / (v[a] - v[b]);
        sum += at;
        ++crossings;
      }
    }
    object.positions.push_back(point(cell.x, cell.y, cell.z) + cell_m * sum / static_cast<float>(crossings));
    return static_cast<int>(object.positions.size()) - 1;
  };
  object.triangles = surface_nets(grid, for_cells, add_vertex);
  object.rest = object.positions;
  smooth_normals(object);
  return object;
}

}  // namespace dualpixel::scenes
