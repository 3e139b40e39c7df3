#include "scenes/make_scenes/sdf_mesh.h"

#include <cmath>

#include "scenes/procedural/signed_distance.h"
#include "scenes/procedural/surface_nets.h"

namespace dualpixel::scenes {

float sdf_ellipsoid(glm::vec3 p, glm::vec3 center, glm::vec3 radii) { return ellipsoid(p, center, radii); }

float sdf_capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b) {
  return capsule(p, a, b, radius_a, radius_b);
}

float sdf_union(float a, float b, float k) { return blend(a, b, k); }

float sdf_subtract(float a, float b, float k) { return carve(a, b, k); }

Mesh mesh_sdf(const Sdf& sdf, glm::vec3 low, glm::vec3 high, float cell_m, float texture_m) {
  DistanceGrid grid(glm::ivec3(glm::ceil((high - low) / cell_m)) + 1);
  const glm::ivec3 n = grid.n;
  const auto point = [&](int x, int y, int z) { return low + cell_m * glm::vec3(x, y, z); };
  for (int z = 0; z < n.z; ++z) {
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x) grid.value[grid.index(x, y, z)] = sdf(point(x, y, z));
    }
  }
  const auto for_cells = [&](const auto& visit) {
    for (int z = 0; z + 1 < n.z; ++z) {
      for (int y = 0; y + 1 < n.y; ++y) {
        for (int x = 0; x + 1 < n.x; ++x) visit(x, y, z);
      }
    }
  };
  Mesh mesh;
  const glm::vec3 middle = 0.5f * (low + high);
  const auto add_vertex = [&](glm::ivec3 cell, const float(&v)[8]) {
    glm::vec3 sum(0);
    int crossings = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int corner = 0; corner < 4; ++corner) {
        glm::ivec3 a(0);
        a[(axis + 1) % 3] += corner & 1;
        a[(axis + 2) % 3] += corner >> 1;
        glm::ivec3 b = a;
        b[axis] += 1;
        const float va = v[a.x | a.y << 1 | a.z << 2], vb = v[b.x | b.y << 1 | b.z << 2];
        if ((va < 0) == (vb < 0)) continue;
        a += cell, b += cell;
        sum += glm::mix(point(a.x, a.y, a.z), point(b.x, b.y, b.z), va / (va - vb));
        ++crossings;
      }
    }
    const glm::vec3 p = sum / static_cast<float>(crossings);
    const float e = 0.5f * cell_m;
    const glm::vec3 gradient(sdf(p + glm::vec3(e, 0, 0)) - sdf(p - glm::vec3(e, 0, 0)),
                             sdf(p + glm::vec3(0, e, 0)) - sdf(p - glm::vec3(0, e, 0)),
                             sdf(p + glm::vec3(0, 0, e)) - sdf(p - glm::vec3(0, 0, e)));
    mesh.positions.push_back(p);
    mesh.normals.push_back(glm::length(gradient) > 0 ? glm::normalize(gradient) : glm::vec3(0, 1, 0));
    // the seam is at the back; a nominal radius of 9 cm turns angle into length
    const float angle = std::atan2(p.x - middle.x, p.z - middle.z);
    mesh.uvs.push_back(glm::vec2(0.09f * angle, -p.y) / texture_m);
    return static_cast<int>(mesh.positions.size()) - 1;
  };
  mesh.triangles = surface_nets(grid, for_cells, add_vertex);
  return mesh;
}

}  // namespace dualpixel::scenes
