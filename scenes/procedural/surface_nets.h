#pragma once
#include <algorithm>
#include <glm/glm.hpp>
#include <vector>

/// Surface nets (Gibson 1998): a closed triangle mesh of the zero level of a sampled signed distance.
namespace dualpixel::scenes {

/// Samples of a distance on a regular grid.
struct DistanceGrid {
  glm::ivec3 n;              ///< grid points along each axis
  std::vector<float> value;  ///< x fastest

  explicit DistanceGrid(glm::ivec3 points) : n(points), value(index(0, 0, points.z)) {}
  std::size_t index(int x, int y, int z) const { return (static_cast<std::size_t>(z) * n.y + y) * n.x + x; }
};

/// `for_cells(visit)` calls visit(x, y, z) for all cells (named by their low corner) that the surface may cross; twice
/// is allowed. `add_vertex(cell, v)` makes the vertex of a crossed cell, of which v holds the eight corner values (bit
/// 0: x + 1, bit 1: y + 1, bit 2: z + 1) and returns its index. Vertices are made in the order of the visits, then
/// triangles, counterclockwise from outside.
template <typename ForCells, typename AddVertex>
std::vector<glm::uvec3> surface_nets(const DistanceGrid& grid, const ForCells& for_cells, const AddVertex& add_vertex) {
  const std::vector<float>& value = grid.value;
  const std::size_t step[3] = {1, static_cast<std::size_t>(grid.n.x), static_cast<std::size_t>(grid.n.x) * grid.n.y};
  std::vector<int> vertex(value.size(), -1);  // of the cell whose low corner is that grid point
  for_cells([&](int x, int y, int z) {
    const std::size_t corner = grid.index(x, y, z);
    if (vertex[corner] >= 0) return;
    float v[8];
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      v[c] = value[corner + (c & 1) * step[0] + ((c >> 1) & 1) * step[1] + (c >> 2) * step[2]];
      inside += v[c] < 0 ? 1 : 0;
    }
    if (inside > 0 && inside < 8) vertex[corner] = add_vertex(glm::ivec3(x, y, z), v);
  });
  // an edge with a change of sign is shared by four cells, whose vertices make a quad
  std::vector<glm::uvec3> triangles;
  std::vector<bool> done(value.size(), false);
  for_cells([&](int x, int y, int z) {
    const std::size_t at = grid.index(x, y, z);
    if (done[at] || x == 0 || y == 0 || z == 0) return;
    done[at] = true;
    for (int axis = 0; axis < 3; ++axis) {
      const bool inside = value[at] < 0;
      if (inside == (value[at + step[axis]] < 0)) continue;
      const std::size_t u = step[(axis + 1) % 3], w = step[(axis + 2) % 3];
      const int corner[4] = {vertex[at - u - w], vertex[at - w], vertex[at], vertex[at - u]};
      if (std::min({corner[0], corner[1], corner[2], corner[3]}) < 0) continue;
      const glm::uvec4 c(corner[0], corner[inside ? 1 : 3], corner[2], corner[inside ? 3 : 1]);
      triangles.emplace_back(c.x, c.y, c.z);
      triangles.emplace_back(c.x, c.z, c.w);
    }
  });
  return triangles;
}

}  // namespace dualpixel::scenes
