#pragma once
#include "scenes/people/shape/scene_model.h"

/// Direct light of the dome and the key light, without bounces.
namespace dualpixel::scenes {

/// Direct light at the point that one sample met: a shadow ray, and the radiance with and without an occluder.
struct LightSample {
  vec3 origin, towards;
  float reach_m = 0;
  vec3 seen{0}, hidden{0};  ///< radiance when the shadow ray is free, when it is blocked
};

/// What is visible where no object is: the dome's radiance, with clouds where the dome has a sky.
vec3 background_radiance(const DomeLight& dome, vec3 direction);

/// Samples light at barycentric coordinates b1, b2 of triangle t, seen along `eye_direction`: from the key light or
/// from the dome. u, v: uniform numbers.
LightSample sample_light(const SceneModel& scene, const SceneObject& object, const glm::uvec3& t, float b1, float b2,
                         vec3 eye_direction, bool key, float u, float v);

}  // namespace dualpixel::scenes
