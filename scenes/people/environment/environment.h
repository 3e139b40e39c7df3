#pragma once
#include <string>

#include "scenes/people/shape/scene_model.h"

/// Where a picture is taken: rooms, walls, studios, gardens, streets, landscapes, nights.
namespace dualpixel::scenes {

/// The last `kReservedEnvironmentKinds` are drawn for held-out sets only.
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

/// Adds walls, ground and objects behind and beside the people; the farthest wall is about `back_m` behind them.
/// Returns the tag that says which kind it is: "place:room".
std::string add_environment(SceneModel& scene, RandomStream rng, float back_m);

}  // namespace dualpixel::scenes
