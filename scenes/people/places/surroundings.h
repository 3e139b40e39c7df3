#pragma once
#include <string>

#include "scenes/people/shape/stage.h"

/// Where pictures are taken, and by what light: rooms, walls, studios, gardens, streets, landscapes, nights.
namespace dualpixel::scenes {

/// The last `kReservedPlaces` and `kReservedLights` are drawn for held-out sets only.
enum class EnvironmentKind : std::uint8_t {
  studio,
  room,
  wall,
  garden,
  street,
  painted,
  landscape,
  night,
  jumble,
  rows,
  mixed,
  // held-out
  market,
  library
};
inline constexpr int kEnvironmentKinds = 13, kReservedEnvironmentKinds = 2;
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

/// Adds walls, ground, things behind and beside; what closes the place off stands about `back_m` behind the people.
/// Returns the place's tag.
std::string add_environment(SceneModel& scene, RandomStream rng, float back_m);

/// Sets dome and key light; a lamp's strength is such that a white wall is about 1.
std::string set_lighting(SceneModel& scene, RandomStream rng);

/// Something between the camera and the people: a table's edge, leaves, a rail. `camera`: where from; `top_m`: up to
/// this height.
void add_foreground(SceneModel& scene, RandomStream rng, vec3 camera, float top_m);

}  // namespace dualpixel::scenes
