#pragma once
#include <glm/glm.hpp>

#include "simulator/lens/lens_sampler.h"

namespace dualpixel::simulator {

/// The camera's pose, lens and sensor: what turns a position on the sensor and one in the pupil into a ray.
/// Camera axes: x right, y down, z forward, origin at the center of the entrance pupil.
struct CameraView {
  glm::mat4 world_from_camera{1};  ///< rigid
  LensSampler lens;
};

}  // namespace dualpixel::simulator
