#pragma once
#include <glm/glm.hpp>

#include "simulator/lens/lens_sampler.h"

namespace dualpixel::simulator {

/// Where the camera stands, its lens and its sensor: what turns a place on the sensor and one in the pupil into a ray.
/// Camera axes: x right, y down, z forward, origin at the centre of the entrance pupil.
struct CameraView {
  glm::mat4 world_from_camera{1};  ///< rigid
  LensSampler lens;
};

}  // namespace dualpixel::simulator
