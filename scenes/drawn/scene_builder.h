#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "scenes/gltf/glb.h"
#include "scenes/textures/surfaces.h"

/// A scene under construction: the glTF file and the scene file that puts a camera into it.
namespace dualpixel::scenes {

/// How bright the picture should be, and what the camera focuses on.
struct Shooting {
  float key = 0.16f;                 ///< geometric mean of the picture over the white level
  float most_clipped = 0.03f;        ///< share of the picture that may be brighter than white
  std::optional<float> focus_m;      ///< along the optical axis; none: a visible surface that the seed picks
  std::optional<glm::vec3> subject;  ///< must be in the picture, and nothing before it: see view_fault()
  float clear_m = 0.1f;              ///< hardly anything may be nearer to the camera
};

class SceneBuilder {
 public:
  SceneBuilder();

  int add(const Surface& surface);
  int add_material(const GlbMaterial& material);
  /// Meshes without triangles are left out. UVs are meters.
  void add(const std::string& name, Mesh mesh, int surface);
  void add(const std::string& name, Mesh mesh, const Surface& surface) { add(name, std::move(mesh), add(surface)); }
  /// For instances of one mesh with several surfaces.
  int add_shared(std::vector<std::pair<Mesh, int>> parts);
  void place(const std::string& name, int shared, const glm::mat4& pose) { glb.add_instance(name, shared, pose); }

  void camera(glm::vec3 eye, glm::vec3 look_at);
  /// Sharpest at this point, which must be seen.
  void focus_on(glm::vec3 point);
  /// The sky of the scene file and its sun as a directional light of `sun_lux`.
  void sky(float elevation_deg, float azimuth_deg, float sun_lux, float zenith_nits, float horizon_nits,
           float ground_nits, glm::vec3 sun_color = glm::vec3(1, 0.95f, 0.86f));
  /// The same radiance from everywhere.
  void ambient(glm::vec3 nits);

  Glb glb;
  nlohmann::json scene;  ///< fields of the scene file
  Shooting shooting;
  glm::vec3 eye{0}, forward{0, 0, -1};
  std::vector<glm::vec3> face;  ///< points about the subject's face, in the world; empty: there is none

 private:
  std::vector<float> repeat_m_;  ///< of each material
};

}  // namespace dualpixel::scenes
