#include "scenes/people/body/frame.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace dualpixel::scenes {

mat3 rotation(float angle, vec3 axis) { return mat3(glm::rotate(glm::mat4(1), angle, axis)); }

mat3 rotation_between(vec3 a, vec3 b) {
  const vec3 axis = glm::cross(a, b);
  const float sine = glm::length(axis), cosine = glm::dot(a, b);
  if (sine < 1e-5f) return cosine > 0 ? mat3(1) : rotation(3.14159265f, {1, 0, 0});
  return rotation(std::atan2(sine, cosine), axis / sine);
}

mat3 axes_along(vec3 along, vec3 towards) {
  const vec3 y = glm::normalize(along);
  vec3 z = towards - y * glm::dot(towards, y);
  z = glm::length(z) > 1e-4f ? glm::normalize(z) : glm::normalize(glm::cross(y, vec3(0.3f, 0.9f, 0.1f)));
  return {glm::cross(y, z), y, z};
}

vec3 bend_limb(vec3 a, vec3& b, float first_m, float second_m, vec3 pole) {
  const vec3 d = b - a;
  const float distance = glm::length(d);
  const vec3 along = distance > 1e-4f ? d / distance : vec3(0, -1, 0);
  const float reach = std::clamp(distance, 1.05f * std::abs(first_m - second_m) + 0.01f, 0.995f * (first_m + second_m));
  b = a + along * reach;
  const float x = (first_m * first_m - second_m * second_m + reach * reach) / (2 * reach);
  vec3 across = pole - along * glm::dot(pole, along);
  across = glm::length(across) > 1e-4f ? glm::normalize(across) : vec3(0, 0, -1);
  return a + along * x + across * std::sqrt(std::max(first_m * first_m - x * x, 0.0f));
}

}  // namespace dualpixel::scenes
