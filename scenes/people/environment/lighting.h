#pragma once
#include <string>

#include "scenes/people/shape/scene_model.h"

namespace dualpixel::scenes {

/// The last `kReservedLightingKinds` are drawn for held-out sets only.
enum class LightingKind : std::uint8_t {
  overcast,
  sun_side,
  sun_behind,
  window,
  ceiling,
  softbox,
  flash,
  lamp,
  neon,
  golden,
  skylight
};
inline constexpr int kLightingKinds = 11, kReservedLightingKinds = 2;

/// Sets the dome light and the key light, so that a white wall is about 1. Returns the tag, "light:window".
std::string set_lighting(SceneModel& scene, RandomStream rng);

}  // namespace dualpixel::scenes
