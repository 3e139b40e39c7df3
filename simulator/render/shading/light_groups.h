#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace dualpixel::simulator {

/// A punctual light or an emissive triangle, as far as a choice among many goes.
struct LightSource {
  std::size_t index = 0;      ///< the caller's
  glm::vec3 low{0}, high{0};  ///< bounds
  float candela = 0;          ///< averaged over directions
  float average_lux = 0;      ///< its weight: illuminance of a surface somewhere in the scene that faces it, or more
};

/// Lights that lie close together.
struct LightGroup {
  std::size_t first = 0, end = 0;  ///< of the lights
  glm::vec3 center{0};             ///< of a sphere that holds them
  float radius_m = 0;
  float candela = 0, average_lux = 0;  ///< of all
};

/// At most so many groups, halved first where luminous intensity times squared extent is largest. Reorders the lights,
/// so that those of a group follow each other; the same lights give the same groups.
std::vector<LightGroup> group_lights(std::vector<LightSource>& lights, std::size_t most);

}  // namespace dualpixel::simulator
