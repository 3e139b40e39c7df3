#pragma once
#include <vector>

#include "scenes/people/shape/look.h"
#include "scenes/people/shape/sdf.h"

/// What stands before the camera: triangles with solid textures. World axes: meters, y up, the floor is y = 0; people
/// stand about the origin and face +z, where the camera is.
namespace dualpixel::scenes {

/// Piece::person of the surroundings, and of people who are in nobody's mask.
inline constexpr int kNoPerson = -1, kBystander = -2;

/// One thing of one look. `rest` is where each vertex lies in its texture's own space, meters: for a body, unposed;
/// for a wall, along it; for a head, relative to the middle between the ears.
struct SceneObject {
  std::vector<vec3> positions;
  std::vector<vec3> rest;
  std::vector<vec3> normals;  ///< unit
  std::vector<glm::uvec3> triangles;
  int material = 0;        ///< index into Stage::looks
  int person = kNoPerson;  ///< who wears, holds or is it
};

/// Light that comes from all around, by direction: a gradient from the ground over the horizon to straight up, and a
/// broad lobe (a window, a bright wall, a glow). Radiance in units of the picture's mid gray, about.
struct DomeLight {
  vec3 up{1}, horizon{1}, down{0.4f};
  vec3 lobe_direction{0, 0, 1}, lobe{0};
  float lobe_sharpness = 4;
  bool sky = false;  ///< what is seen where nothing stands: clouds, else the gradient
  std::uint32_t seed = 1;
};

/// The one light that throws hard or soft shadows.
struct KeyLight {
  vec3 direction{0, 1, 0};  ///< towards it, unit
  vec3 irradiance{1};
  float spread = 0.05f;  ///< radius of its disc over its distance
};

struct SceneModel {
  std::vector<Material> materials;
  std::vector<SceneObject> objects;
  DomeLight dome;
  KeyLight key;

  int add(const Material& material) {
    materials.push_back(material);
    return static_cast<int>(materials.size()) - 1;
  }
};

/// Normals from the triangles about each vertex, weighed by area.
void smooth_normals(SceneObject& object);

/// The six sides of a box with half sizes `half` in the frame `axes` about `center`; rest runs along each side.
void add_box(SceneObject& object, vec3 center, const mat3& axes, vec3 half, vec3 rest_shift = vec3(0));
/// A rectangle with the corners corner, corner + a, corner + a + b, corner + b; rest is (along a, along b, 0).
void add_quad(SceneObject& object, vec3 corner, vec3 a, vec3 b, vec3 rest_shift = vec3(0));
/// A tube along a path; `rest` is (around, along, 0). Open at its ends where their radius is not 0.
void add_tube(SceneObject& object, const std::vector<vec3>& path, const std::vector<float>& radii, int sides = 8);
/// A ball; rest is the unit direction in the frame `axes`.
void add_ellipsoid(SceneObject& object, vec3 center, vec3 radii, const mat3& axes, int rows = 10);

/// The zero surface of `distance(p)` inside the box by surface nets (Gibson 1998) on cells of `cell_m`; blocks that the
/// surface cannot cross are looked at once. rest = position.
template <typename Distance>
SceneObject polygonize(const Distance& distance, vec3 low, vec3 high, float cell_m) {
  constexpr int kBlock = 6;
  const glm::ivec3 n = (glm::ivec3(glm::ceil((high - low) / cell_m)) / kBlock + 1) * kBlock;  // grid points
  const auto index = [&](int x, int y, int z) { return (static_cast<std::size_t>(z) * n.y + y) * n.x + x; };
  const auto point = [&](int x, int y, int z) { return low + cell_m * vec3(x, y, z); };
  std::vector<float> value(index(0, 0, n.z));
  std::vector<glm::ivec3> crossed;
  const float reach = 0.5f * kBlock * cell_m * 1.7320508f * 1.5f;  // 1.5: distances are not quite true
  for (int z = 0; z < n.z; z += kBlock) {
    for (int y = 0; y < n.y; y += kBlock) {
      for (int x = 0; x < n.x; x += kBlock) {
        const float middle = distance(point(x, y, z) + 0.5f * (kBlock - 1) * cell_m);
        const bool near = std::abs(middle) < reach;
        if (near) crossed.emplace_back(x, y, z);
        for (int k = z; k < z + kBlock; ++k) {
          for (int j = y; j < y + kBlock; ++j) {
            for (int i = x; i < x + kBlock; ++i) value[index(i, j, k)] = near ? distance(point(i, j, k)) : middle;
          }
        }
      }
    }
  }
  SceneObject object;
  std::vector<int> vertex(value.size(), -1);  // of the cell whose low corner is that grid point
  const std::size_t step[3] = {1, static_cast<std::size_t>(n.x), static_cast<std::size_t>(n.x) * n.y};
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
  for_cells([&](int x, int y, int z) {
    const std::size_t corner = index(x, y, z);
    if (vertex[corner] >= 0) return;
    float v[8];
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      v[c] = value[corner + (c & 1) * step[0] + ((c >> 1) & 1) * step[1] + (c >> 2) * step[2]];
      inside += v[c] < 0 ? 1 : 0;
    }
    if (inside == 0 || inside == 8) return;
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
    vertex[corner] = static_cast<int>(object.positions.size());
    object.positions.push_back(point(x, y, z) + cell_m * sum / static_cast<float>(crossings));
  });
  std::vector<bool> done(value.size(), false);
  for_cells([&](int x, int y, int z) {
    const std::size_t at = index(x, y, z);
    if (done[at] || x == 0 || y == 0 || z == 0) return;
    done[at] = true;
    for (int axis = 0; axis < 3; ++axis) {
      const bool inside = value[at] < 0;
      if (inside == (value[at + step[axis]] < 0)) continue;
      const std::size_t u = step[(axis + 1) % 3], w = step[(axis + 2) % 3];
      const int corner[4] = {vertex[at - u - w], vertex[at - w], vertex[at], vertex[at - u]};
      if (std::min({corner[0], corner[1], corner[2], corner[3]}) < 0) continue;
      const glm::uvec4 c(corner[0], corner[inside ? 1 : 3], corner[2], corner[inside ? 3 : 1]);
      object.triangles.emplace_back(c.x, c.y, c.z);
      object.triangles.emplace_back(c.x, c.z, c.w);
    }
  });
  object.rest = object.positions;
  smooth_normals(object);
  return object;
}

}  // namespace dualpixel::scenes
