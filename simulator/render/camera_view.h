#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "simulator/lens/lens_sampler.h"

namespace dualpixel::simulator {

/// The camera's pose, lens and sensor: what turns a position on the sensor and one in the pupil into a ray.
/// Camera axes: x right, y down, z forward, origin at the center of the entrance pupil.
struct CameraView {
  glm::mat4 world_from_camera{1};  ///< rigid
  LensSampler lens;
  /// Of each row, where a shutter that rolls exposes them one after the other; empty: world_from_camera is that of all.
  std::shared_ptr<const std::vector<glm::mat4>> row_poses = nullptr;

  const glm::mat4& pose(int row) const {
    return row_poses ? (*row_poses)[static_cast<std::size_t>(row)] : world_from_camera;
  }
};

}  // namespace dualpixel::simulator
