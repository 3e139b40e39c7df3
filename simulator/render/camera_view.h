#pragma once
#include <glm/glm.hpp>

#include "simulator/lens/split_pixel.h"
#include "simulator/lens/thin_lens.h"

namespace dualpixel::simulator {

/// Where the camera stands and how its sensor is laid out: what turns a position on the sensor and one on the pupil
/// into a ray. Camera axes: x right, y down, z forward, origin at the centre of the entrance pupil.
struct CameraView {
  glm::mat4 world_from_camera{1};  ///< rigid
  ThinLens lens;
  SplitPixel split;
  int width_px = 0;
  int height_px = 0;
  double pixel_pitch_m = 0;
  glm::dvec2 principal_point_px{0};  ///< continuous coordinates
};

}  // namespace dualpixel::simulator
