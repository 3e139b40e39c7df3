#pragma once
#include "scenes/people/environment/builder.h"

/// One function for each kind of environment; `back`: how far behind the people it ends, meters.
namespace dualpixel::scenes {

void add_room(EnvironmentBuilder& build, RandomStream& rng, float back, bool library);
void add_garden(EnvironmentBuilder& build, RandomStream& rng, float back);
void add_street(EnvironmentBuilder& build, RandomStream& rng, float back);
void add_landscape(EnvironmentBuilder& build, RandomStream& rng, float back);
void add_lights_at_night(EnvironmentBuilder& build, RandomStream& rng, float back);
void add_market(EnvironmentBuilder& build, RandomStream& rng, float back);
void add_studio(EnvironmentBuilder& build, RandomStream& rng, float back);
void add_wall(EnvironmentBuilder& build, RandomStream& rng, float back);

// generic shapes and patterns (domain randomization)
void add_painted_backdrop(EnvironmentBuilder& build, RandomStream& rng, float back);
/// Ground and, mostly, a wall beyond `deepest_m`.
void add_ground(EnvironmentBuilder& build, RandomStream& rng, float deepest_m);
/// Random objects at random positions behind the people.
void add_jumble(EnvironmentBuilder& build, RandomStream& rng, float back, int things);
/// The same objects in rows, as shelves, seats, fences and lamps are. Returns how far back they reach.
float add_rows(EnvironmentBuilder& build, RandomStream& rng, float back);
inline constexpr float kLargestInJumble_m = 0.6f;

}  // namespace dualpixel::scenes
