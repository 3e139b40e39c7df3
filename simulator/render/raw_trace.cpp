#include "simulator/render/raw_trace.h"

#include <limits>

#include "simulator/render/camera_rays.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {

std::size_t trace_raw(const RenderScene& world, const CameraView& camera, int samples_per_pixel, glm::vec3 to_light) {
  alignas(64) float joint[4][kPacket];
  LensPacket packet;
  alignas(64) RTCRayHit16 rays;
  alignas(64) RTCRay16 shadow;
  alignas(64) int all[kPacket];
  alignas(64) int hit[kPacket];
  for (int& lane : all) lane = -1;
  std::size_t lit = 0;
  for (int y = 0; y < camera.lens.sensor().height_px; ++y) {
    for (int x = 0; x < camera.lens.sensor().width_px; ++x) {
      const std::uint64_t key = hash(1, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x));
      for (int first = 0; first < samples_per_pixel; first += kPacket) {
        joint_samples(first, key, joint);
        camera.lens.sample(x, y, 1, joint, packet);
        to_world(packet, camera.world_from_camera, rays);
        world.intersector.intersect(all, rays, true);
        for (int i = 0; i < kPacket; ++i) {
          hit[i] = rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? 0 : -1;
          const float t = hit[i] ? rays.ray.tfar[i] * (1 - 1e-4f) : 0;
          shadow.org_x[i] = rays.ray.org_x[i] + t * rays.ray.dir_x[i];
          shadow.org_y[i] = rays.ray.org_y[i] + t * rays.ray.dir_y[i];
          shadow.org_z[i] = rays.ray.org_z[i] + t * rays.ray.dir_z[i];
          shadow.dir_x[i] = to_light.x;
          shadow.dir_y[i] = to_light.y;
          shadow.dir_z[i] = to_light.z;
          shadow.tnear[i] = 0;
          shadow.tfar[i] = std::numeric_limits<float>::infinity();
          shadow.time[i] = 0;
          shadow.mask[i] = ~0u;
          shadow.flags[i] = 0;
        }
        world.intersector.occluded(hit, shadow, true);
        for (int i = 0; i < kPacket; ++i) lit += hit[i] && shadow.tfar[i] >= 0;
      }
    }
  }
  return lit;
}

}  // namespace dualpixel::simulator
