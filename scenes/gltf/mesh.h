#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

/// Triangles and pictures as a glTF file holds them. Lengths in meters, glTF's axes.
namespace dualpixel::scenes {

struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  ///< empty: flat
  std::vector<glm::vec2> uvs;
  std::vector<glm::uvec3> triangles;

  /// Corner, corner + a, corner + a + b, corner + b; UVs run along a and, downwards, against b, `repeat` times.
  void add_quad(glm::vec3 corner, glm::vec3 a, glm::vec3 b, glm::vec2 repeat = {1, 1});
};

/// 8-bit sRGB texels, rows from top to bottom.
struct Texture {
  int size = 0;
  std::vector<std::uint8_t> rgb;
};

/// Adds what `other` holds. Both have the same arrays, or `mesh` is empty.
void append(Mesh& mesh, const Mesh& other);

/// `mesh` turned, scaled and moved.
Mesh placed_mesh(Mesh mesh, const glm::mat4& pose);

/// Takes out triangles without area, which readers would warn of.
void drop_flat_triangles(Mesh& mesh);

}  // namespace dualpixel::scenes
