#pragma once
#include <limits>

#include "simulator/lens/lens_packet.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/intersector.h"

/// From a lens's rays to the scene's: the world's axes, t = planar depth.
namespace dualpixel::simulator {

inline void to_world(const LensPacket& packet, const glm::mat4& world_from_camera, RayPacket& rays) {
  const glm::mat3 rotation(world_from_camera);
  const glm::vec3 origin(world_from_camera[3]);
  for (int i = 0; i < kPacket; ++i) {
    const float x = packet.origin_x[i], y = packet.origin_y[i];
    const float dx = packet.slope_x[i], dy = packet.slope_y[i];
    rays.origin_x[i] = origin.x + rotation[0].x * x + rotation[1].x * y;
    rays.origin_y[i] = origin.y + rotation[0].y * x + rotation[1].y * y;
    rays.origin_z[i] = origin.z + rotation[0].z * x + rotation[1].z * y;
    rays.direction_x[i] = rotation[0].x * dx + rotation[1].x * dy + rotation[2].x;
    rays.direction_y[i] = rotation[0].y * dx + rotation[1].y * dy + rotation[2].y;
    rays.direction_z[i] = rotation[0].z * dx + rotation[1].z * dy + rotation[2].z;
    rays.far[i] = std::numeric_limits<float>::infinity();
    rays.mesh[i] = kNoMesh;
  }
}

/// The green chief ray of a pixel.
inline Ray chief_ray(const CameraView& camera, int x, int y) {
  const glm::dvec2 at = camera.lens.sensor().middle_m(x, y);
  const glm::mat4& pose = camera.pose(y);
  return {glm::vec3(pose[3]), glm::mat3(pose) * glm::vec3(camera.lens.chief_slope(at.x, at.y), 1)};
}

}  // namespace dualpixel::simulator
