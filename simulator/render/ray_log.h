#pragma once
#include <cstddef>
#include <vector>

#include "simulator/render/intersector.h"

/// The rays of a render, written down to be traced again by themselves: what Embree alone takes for them is the floor
/// that `dualpixel bench` measures the renderer against.
namespace dualpixel::simulator {

struct LoggedRays {
  RayPacket rays;
  alignas(64) int active[kPacket];  ///< -1 or 0
  bool shadow;                      ///< any hit will do
  bool coherent;                    ///< as Embree was told
};

using RayLog = std::vector<LoggedRays>;

void write_down(RayLog& log, const int active[kPacket], const RayPacket& rays, bool shadow, bool coherent);

/// In packets of `width` (1, 8 or 16) on the calling thread. Returns how many rays met something.
std::size_t replay(const Intersector& intersector, const RayLog& log, int width);

}  // namespace dualpixel::simulator
