#pragma once
#include "scenes/people/shape/primitives.h"

/// What environments are made from.
namespace dualpixel::scenes {

/// A rotation by `angle` radians about the vertical axis.
mat3 rotation_about_y(float angle);

/// Adds one environment to a scene, object by object.
class EnvironmentBuilder {
 public:
  EnvironmentBuilder(SceneModel& scene, RandomStream& rng) : scene_(scene), rng_(rng), first_(scene.objects.size()) {}

  SceneObject& object(const Material& material) {
    SceneObject& p = scene_.objects.emplace_back();
    p.material = scene_.add(material);
    return p;
  }
  void box(vec3 center, vec3 half, const Material& material, float yaw = 0) {
    add_box(object(material), center, rotation_about_y(yaw), half, rng_.uniform3(0, 1));
  }
  void quad(vec3 corner, vec3 a, vec3 b, const Material& material) { add_quad(object(material), corner, a, b); }
  /// Turns all that was added about the vertical axis through the people.
  void turn(float yaw) {
    const mat3 axes = rotation_about_y(yaw);
    for (std::size_t i = first_; i < scene_.objects.size(); ++i) {
      for (vec3& p : scene_.objects[i].positions) p = axes * p;
      for (vec3& n : scene_.objects[i].normals) n = axes * n;
    }
  }

 private:
  SceneModel& scene_;
  RandomStream& rng_;
  std::size_t first_;
};

/// A light source: emits `radiance`.
Material emissive_material(vec3 radiance);

}  // namespace dualpixel::scenes
