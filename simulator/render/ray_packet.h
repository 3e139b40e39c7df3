#pragma once
#include <glm/glm.hpp>

#include "simulator/sampling/packet.h"

namespace dualpixel::simulator {

inline constexpr unsigned kNoMesh = ~0u;

/// One ray. It begins at t = 0 and has no end; the direction's length is t's unit.
struct Ray {
  glm::vec3 origin{0};
  glm::vec3 direction{0, 0, 1};
};

/// What one ray met.
struct Hit {
  float t = 0;
  unsigned mesh = 0;  ///< of Scene::meshes
  unsigned triangle = 0;
  float u = 0, v = 0;      ///< barycentric weights of the triangle's second and third corner
  unsigned placement = 0;  ///< of the mesh's placements, where it has any
};

/// Sixteen rays, and what they meet. They begin at t = 0; a direction's length is t's unit.
struct RayPacket {
  alignas(64) float origin_x[kPacket], origin_y[kPacket], origin_z[kPacket];
  alignas(64) float direction_x[kPacket], direction_y[kPacket], direction_z[kPacket];
  alignas(64) float far[kPacket];      ///< t where the ray ends; after Intersector::intersect() that of the hit
  alignas(64) unsigned mesh[kPacket];  ///< of Scene::meshes; kNoMesh: nothing was met
  alignas(64) unsigned triangle[kPacket];
  alignas(64) float u[kPacket], v[kPacket];  ///< barycentric weights of the triangle's second and third corner
  alignas(64) unsigned placement[kPacket];   ///< of the mesh's placements; unset where it has none
};

}  // namespace dualpixel::simulator
