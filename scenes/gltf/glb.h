#pragma once
#include <tbb/task_group.h>

#include <atomic>
#include <deque>
#include <glm/glm.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scenes/gltf/mesh.h"

/// A scene under construction and the binary glTF file that it becomes. Lengths in meters, glTF's axes.
namespace dualpixel::scenes {

/// What light does at a surface, as glTF's metallic-roughness model and its extensions have it.
struct GlbMaterial {
  int texture = -1;  ///< of the color, -1: none
  glm::vec3 color{1};
  bool unlit = false;  ///< glows with its texture and color
  float roughness = 1;
  float metallic = 0;
  glm::vec3 emission_nits{0};
  float transmission = 0;  ///< share of the light that passes, tinted by the color
  bool solid = false;      ///< of glass through and through; otherwise a thin pane
  float subsurface = 0;    ///< share of the diffuse light that comes from within, as of skin
  bool cut_out = false;    ///< nothing is there where the texture's alpha is below 1/2
};

class Glb {
 public:
  Glb() = default;
  Glb(Glb&&) = default;
  /// What the file says that made it, and how hard pictures are compressed, 1 to 9; before anything else.
  void set_generator(const std::string& name, int png_level);
  int add_texture(const Texture& texture);
  /// sRGB and alpha, row by row from the top.
  int add_texture(int width, int height, const std::vector<unsigned char>& rgba);
  int add_material(const GlbMaterial& material);
  /// `texture` -1: none. Unlit materials glow with their texture; others are plainly diffuse at roughness 1.
  int add_material(int texture, glm::vec3 color, bool unlit, float roughness = 1);
  void add_node(const std::string& name, const Mesh& mesh, int material, bool person = false);
  /// A person with a linear color for each vertex.
  void add_colored_person(const std::string& name, const Mesh& mesh, const std::vector<glm::vec3>& colors,
                          int material);
  /// Strands of a person's hair: points with a width in meters and a linear color, and pairs of points.
  void add_person_hair(const std::string& name, const std::vector<glm::vec3>& points,
                       const std::vector<float>& widths_m, const std::vector<glm::vec3>& colors,
                       const std::vector<glm::uvec2>& segments, int material);
  /// A mesh for add_instance(): parts with a material each.
  int add_mesh(const std::vector<std::pair<const Mesh*, int>>& parts);
  void add_instance(const std::string& name, int mesh, const glm::mat4& pose);
  void add_camera(const std::string& name, glm::vec3 position, glm::vec3 look_at);
  void add_sun(glm::vec3 direction, glm::vec3 color, float lux);
  /// Lets the node that was added last move: its translation at two times, between which it goes evenly.
  void move_last_node(float from_s, glm::vec3 from, float to_s, glm::vec3 to);
  void write(const std::string& path) const;

 private:
  int add_picture(int width, int height, int channels, const std::vector<unsigned char>& pixels);
  int add_view(std::string bytes);
  std::size_t add_accessor(const void* data, std::size_t count, int components, int type);
  std::size_t add_positions(const std::vector<glm::vec3>& positions);
  nlohmann::json primitive(const Mesh& mesh, int material);
  /// With the mesh that was added last.
  void add_person_node(const std::string& name);
  void use(const std::string& extension);
  // here and not in a .cpp: code that makes the shipped scenes is inlined by its size, and rounds accordingly
  nlohmann::json root_ = {{"asset", {{"version", "2.0"}, {"generator", "dualpixel_make_scenes"}}}};
  int png_level_ = 6;
  /// What each buffer view holds. Pictures are encoded into theirs on other threads while the scene grows.
  struct Views {
    std::deque<std::string> bytes;         // whose elements stay where they are
    std::atomic<std::size_t> waiting = 0;  // bytes of pictures that are not encoded yet
    tbb::task_group encoding;
    ~Views();
  };
  std::unique_ptr<Views> views_ = std::make_unique<Views>();
};

}  // namespace dualpixel::scenes
