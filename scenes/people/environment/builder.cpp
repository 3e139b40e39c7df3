#include "scenes/people/environment/builder.h"

#include <glm/gtc/matrix_transform.hpp>

namespace dualpixel::scenes {

mat3 rotation_about_y(float angle) { return mat3(glm::rotate(glm::mat4(1), angle, vec3(0, 1, 0))); }

Material emissive_material(vec3 radiance) {
  Material material = plain_material(vec3(1));
  material.emission = radiance;
  return material;
}

}  // namespace dualpixel::scenes
