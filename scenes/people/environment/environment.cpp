#include "scenes/people/environment/environment.h"

#include <iterator>

#include "scenes/people/environment/environments.h"

namespace dualpixel::scenes {
namespace {

/// Random objects in front of the back of an ordinary environment.
void add_mixed(EnvironmentBuilder& build, RandomStream& rng, float back);

void add_kind(EnvironmentBuilder& build, RandomStream& rng, EnvironmentKind kind, float back) {
  switch (kind) {
    case EnvironmentKind::studio:
      return add_studio(build, rng, back);
    case EnvironmentKind::room:
      return add_room(build, rng, back, false);
    case EnvironmentKind::library:
      return add_room(build, rng, back, true);
    case EnvironmentKind::wall:
      return add_wall(build, rng, back);
    case EnvironmentKind::garden:
      return add_garden(build, rng, back);
    case EnvironmentKind::street:
      return add_street(build, rng, back);
    case EnvironmentKind::painted:
      return add_painted_backdrop(build, rng, back);
    case EnvironmentKind::landscape:
      return add_landscape(build, rng, back);
    case EnvironmentKind::night:
      return add_lights_at_night(build, rng, back);
    case EnvironmentKind::jumble:
      add_ground(build, rng, back + 0.5f + 3 * kLargestInJumble_m);
      return add_jumble(build, rng, back, 8 + rng.below(40));
    case EnvironmentKind::rows:
      return add_ground(build, rng, add_rows(build, rng, back));
    case EnvironmentKind::mixed:
      return add_mixed(build, rng, back);
    case EnvironmentKind::market:
      return add_market(build, rng, back);
  }
}

void add_mixed(EnvironmentBuilder& build, RandomStream& rng, float back) {
  constexpr EnvironmentKind kOrdinary[] = {EnvironmentKind::studio,    EnvironmentKind::room,
                                           EnvironmentKind::garden,    EnvironmentKind::street,
                                           EnvironmentKind::landscape, EnvironmentKind::painted};
  const float behind_m = back + (1.5f * kLargestInJumble_m + 0.7f);  // most of what comes at 0.4 back
  add_kind(build, rng, kOrdinary[rng.below(static_cast<int>(std::size(kOrdinary)))], behind_m);
  if (rng.chance(0.6f)) add_rows(build, rng, 0.4f * back);
  add_jumble(build, rng, 0.4f * back, rng.below(16));
}

}  // namespace

std::string add_environment(SceneModel& scene, RandomStream rng, float back_m) {
  constexpr const char* kNames[] = {"studio", "room",   "wall", "garden", "street", "painted", "landscape",
                                    "night",  "jumble", "rows", "mixed",  "market", "library"};
  static_assert(std::size(kNames) == kEnvironmentKinds &&
                static_cast<int>(EnvironmentKind::library) == kEnvironmentKinds - 1);
  constexpr EnvironmentKind kRandomized[] = {EnvironmentKind::painted, EnvironmentKind::jumble, EnvironmentKind::rows,
                                             EnvironmentKind::mixed, EnvironmentKind::mixed};
  const EnvironmentKind kind =
      rng.domain_randomized() && rng.chance(0.6f)
          ? kRandomized[rng.below(static_cast<int>(std::size(kRandomized)))]
          : static_cast<EnvironmentKind>(rng.choose(kEnvironmentKinds, kReservedEnvironmentKinds));
  EnvironmentBuilder build(scene, rng);
  scene.dome.seed = rng.seed();
  add_kind(build, rng, kind, back_m);
  build.turn(0.22f * rng.normal());
  return std::string("place:") + kNames[static_cast<int>(kind)];
}

}  // namespace dualpixel::scenes
