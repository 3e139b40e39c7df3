#pragma once
#include "scenes/people/shape/material.h"

namespace dualpixel::scenes {

/// Linear reflectance, about 0 .. 1, at a rest position.
glm::vec3 reflectance(const Material& material, glm::vec3 rest);

}  // namespace dualpixel::scenes
