#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// A scene under construction and the binary glTF file that it becomes. Lengths in meters, glTF's axes.
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

class Glb {
 public:
  int add_texture(const Texture& texture);
  /// `texture` -1: none. Unlit materials glow with their texture; others are plainly diffuse at roughness 1.
  int add_material(int texture, glm::vec3 color, bool unlit, float roughness = 1);
  void add_node(const std::string& name, const Mesh& mesh, int material, bool person = false);
  void add_camera(const std::string& name, glm::vec3 position, glm::vec3 look_at);
  void add_sun(glm::vec3 direction, glm::vec3 color, float lux);
  void write(const std::string& path) const;

 private:
  int add_view(const void* data, std::size_t bytes);
  nlohmann::json root_ = {{"asset", {{"version", "2.0"}, {"generator", "dualpixel_make_scenes"}}}};
  std::string bin_;
};

}  // namespace dualpixel::scenes
