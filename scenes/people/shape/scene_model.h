#pragma once
#include <vector>

#include "scenes/people/shape/material.h"
#include "scenes/procedural/signed_distance.h"

/// What is in front of the camera: triangle meshes with solid textures, and the light. World axes: meters, y up, the
/// floor is y = 0; people stand about the origin and face +z, where the camera is.
namespace dualpixel::scenes {

/// SceneObject::person of the environment, and of bystanders, who are in no mask.
inline constexpr int kNoPerson = -1, kBystander = -2;

/// A mesh with one material. `rest` holds texture coordinates in meters: for a body its rest pose, for a wall the
/// position along it, for a head the position relative to the middle between the ears.
struct SceneObject {
  std::vector<vec3> positions;
  std::vector<vec3> rest;
  std::vector<vec3> normals;  ///< unit
  std::vector<glm::uvec3> triangles;
  int material = 0;        ///< index into Stage::looks
  int person = kNoPerson;  ///< index of the person it belongs to
  float hair_m = 0;        ///< the mass of hair whose strands show about this length; 0: something else
};

/// Light from all directions: a gradient from the ground over the horizon to the zenith, and a broad lobe (a window, a
/// bright wall). Radiance, where 1 is about a mid-gray picture's.
struct DomeLight {
  vec3 up{1}, horizon{1}, down{0.4f};
  vec3 lobe_direction{0, 0, 1}, lobe{0};
  float lobe_sharpness = 4;
  bool sky = false;  ///< clouds are visible in the background; else only the gradient
  std::uint32_t seed = 1;
};

/// The one light that casts shadows.
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

}  // namespace dualpixel::scenes
