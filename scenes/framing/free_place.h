#pragma once
#include <glm/glm.hpp>
#include <optional>

#include "simulator/ready_scene.h"

namespace dualpixel::scenes {

/// A place about a scene: distance from the middle of its box, height over the horizon, and direction, from +z to +x.
struct ShellPlace {
  double distance_m = 1;
  double elevation_deg = 0, azimuth_deg = 0;
};

/// Where a camera at that place that looks at `middle` can stand, or else further around, the golden angle apart: no
/// wall or thing right at it, no solid around it, and nothing just before it on the way to the middle. None where there
/// is no such place.
std::optional<glm::vec3> free_place(const simulator::ReadyScene& ready, glm::vec3 middle, const ShellPlace& wanted);

}  // namespace dualpixel::scenes
