#include "scenes/make_scenes/sdf_mesh.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::scenes {

float ellipsoid(glm::vec3 p, glm::vec3 centre, glm::vec3 radii) {
  const glm::vec3 q = (p - centre) / radii;
  const float k0 = glm::length(q), k1 = glm::length(q / radii);
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

float capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b) {
  const glm::vec3 ab = b - a;
  const float t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0f, 1.0f);
  return glm::length(p - a - t * ab) - (radius_a + (radius_b - radius_a) * t);
}

float smooth_union(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}

float smooth_subtract(float a, float b, float k) { return -smooth_union(-a, b, k); }

Mesh mesh_sdf(const Sdf& sdf, glm::vec3 low, glm::vec3 high, float cell_m, float texture_m) {
  const glm::ivec3 n = glm::ivec3(glm::ceil((high - low) / cell_m)) + 1;  // grid points
  const auto index = [&](int x, int y, int z) { return (static_cast<std::size_t>(z) * n.y + y) * n.x + x; };
  const auto point = [&](int x, int y, int z) { return low + cell_m * glm::vec3(x, y, z); };
  std::vector<float> value(index(0, 0, n.z));
  for (int z = 0; z < n.z; ++z) {
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x) value[index(x, y, z)] = sdf(point(x, y, z));
    }
  }
  Mesh mesh;
  const glm::vec3 middle = 0.5f * (low + high);
  std::vector<int> vertex(value.size(), -1);  // of the cell whose low corner is that grid point
  for (int z = 0; z + 1 < n.z; ++z) {
    for (int y = 0; y + 1 < n.y; ++y) {
      for (int x = 0; x + 1 < n.x; ++x) {
        glm::vec3 sum(0);
        int crossings = 0;
        for (int axis = 0; axis < 3; ++axis) {
          for (int corner = 0; corner < 4; ++corner) {
            glm::ivec3 a(x, y, z);
            a[(axis + 1) % 3] += corner & 1;
            a[(axis + 2) % 3] += corner >> 1;
            glm::ivec3 b = a;
            b[axis] += 1;
            const float va = value[index(a.x, a.y, a.z)], vb = value[index(b.x, b.y, b.z)];
            if ((va < 0) == (vb < 0)) continue;
            sum += glm::mix(point(a.x, a.y, a.z), point(b.x, b.y, b.z), va / (va - vb));
            ++crossings;
          }
        }
        if (crossings == 0) continue;
        vertex[index(x, y, z)] = static_cast<int>(mesh.positions.size());
        const glm::vec3 p = sum / static_cast<float>(crossings);
        const float e = 0.5f * cell_m;
        const glm::vec3 gradient(sdf(p + glm::vec3(e, 0, 0)) - sdf(p - glm::vec3(e, 0, 0)),
                                 sdf(p + glm::vec3(0, e, 0)) - sdf(p - glm::vec3(0, e, 0)),
                                 sdf(p + glm::vec3(0, 0, e)) - sdf(p - glm::vec3(0, 0, e)));
        mesh.positions.push_back(p);
        mesh.normals.push_back(glm::length(gradient) > 0 ? glm::normalize(gradient) : glm::vec3(0, 1, 0));
        // the seam lies at the back; a nominal radius of 9 cm turns angle into length
        const float angle = std::atan2(p.x - middle.x, p.z - middle.z);
        mesh.uvs.push_back(glm::vec2(0.09f * angle, -p.y) / texture_m);
      }
    }
  }
  for (int z = 1; z + 1 < n.z; ++z) {
    for (int y = 1; y + 1 < n.y; ++y) {
      for (int x = 1; x + 1 < n.x; ++x) {
        for (int axis = 0; axis < 3; ++axis) {
          glm::ivec3 next(x, y, z);
          next[axis] += 1;
          const bool inside = value[index(x, y, z)] < 0;
          if (inside == (value[index(next.x, next.y, next.z)] < 0)) continue;
          glm::ivec3 u(0), v(0);
          u[(axis + 1) % 3] = 1;
          v[(axis + 2) % 3] = 1;
          const glm::ivec3 c(x, y, z);
          unsigned corner[4];
          const glm::ivec3 cells[4] = {c - u - v, c - v, c, c - u};
          for (int i = 0; i < 4; ++i) corner[i] = vertex[index(cells[i].x, cells[i].y, cells[i].z)];
          if (!inside) std::swap(corner[1], corner[3]);
          mesh.triangles.push_back({corner[0], corner[1], corner[2]});
          mesh.triangles.push_back({corner[0], corner[2], corner[3]});
        }
      }
    }
  }
  return mesh;
}

}  // namespace dualpixel::scenes
