#include "simulator/render/ray_log.h"

#include <algorithm>

namespace dualpixel::simulator {

void write_down(RayLog& log, const int active[kPacket], const RayPacket& rays, bool shadow, bool coherent) {
  LoggedRays& packet = log.emplace_back(LoggedRays{rays, {}, shadow, coherent});
  std::copy_n(active, kPacket, packet.active);
}

std::size_t replay(const Intersector& intersector, const RayLog& log, int width) {
  std::size_t met = 0;
  for (const LoggedRays& packet : log) {
    RayPacket rays = packet.rays;
    alignas(64) int hidden[kPacket];
    if (packet.shadow) {
      intersector.occluded(packet.active, rays, packet.coherent, hidden, width);
    } else {
      intersector.intersect(packet.active, rays, packet.coherent, width);
    }
    for (int i = 0; i < kPacket; ++i) met += packet.active[i] && (packet.shadow ? hidden[i] : rays.mesh[i] != kNoMesh);
  }
  return met;
}

}  // namespace dualpixel::simulator
