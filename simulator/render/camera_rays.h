#pragma once
#include <limits>

#include "simulator/render/camera_view.h"
#include "simulator/render/intersector.h"

/// From a lens's rays to Embree's: one packet, the world's axes, t = planar depth.
namespace dualpixel::simulator {

inline void reset(RTCRayHit16& rays) {
  for (int i = 0; i < kPacket; ++i) {
    rays.ray.tnear[i] = 0;
    rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
    rays.ray.time[i] = 0;
    rays.ray.mask[i] = ~0u;
    rays.ray.flags[i] = 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
}

inline void to_world(const LensPacket& packet, const glm::mat4& world_from_camera, RTCRayHit16& rays) {
  const glm::mat3 rotation(world_from_camera);
  const glm::vec3 origin(world_from_camera[3]);
  for (int i = 0; i < kPacket; ++i) {
    const float x = packet.origin_x[i], y = packet.origin_y[i];
    const float dx = packet.slope_x[i], dy = packet.slope_y[i];
    rays.ray.org_x[i] = origin.x + rotation[0].x * x + rotation[1].x * y;
    rays.ray.org_y[i] = origin.y + rotation[0].y * x + rotation[1].y * y;
    rays.ray.org_z[i] = origin.z + rotation[0].z * x + rotation[1].z * y;
    rays.ray.dir_x[i] = rotation[0].x * dx + rotation[1].x * dy + rotation[2].x;
    rays.ray.dir_y[i] = rotation[0].y * dx + rotation[1].y * dy + rotation[2].y;
    rays.ray.dir_z[i] = rotation[0].z * dx + rotation[1].z * dy + rotation[2].z;
  }
  reset(rays);
}

}  // namespace dualpixel::simulator
