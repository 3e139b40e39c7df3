#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace dualpixel::simulator {

/// A light that stands in the scene, for the choice among many.
struct NearLight {
  std::size_t index = 0;      ///< of Scene::lights, then of emissive triangles
  glm::vec3 low{0}, high{0};  ///< bounds
  float candela = 0;          ///< of its mean side
  float average_lux = 0;      ///< that it throws on an average point of the scene
};

/// Lights that lie close together.
struct LightGroup {
  std::size_t first = 0, end = 0;  ///< of the lights
  glm::vec3 center{0};             ///< of a sphere that holds them
  float radius_m = 0;
  float candela = 0, average_lux = 0;
};

/// At most so many groups, as compact as their light is strong; sorts the lights by them. The same lights give the same
/// groups.
std::vector<LightGroup> group_lights(std::vector<NearLight>& lights, std::size_t most);

}  // namespace dualpixel::simulator
