#pragma once
#include <glm/glm.hpp>

#include "simulator/sampling/packet.h"

namespace dualpixel::simulator {

/// A vector for each lane of a packet, so that loops over lanes become vector instructions.
struct Vec3Packet {
  alignas(64) float x[kPacket], y[kPacket], z[kPacket];

  glm::vec3 at(int i) const { return {x[i], y[i], z[i]}; }
  void set(int i, glm::vec3 v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
};

}  // namespace dualpixel::simulator
