#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// Adds what the pose holds, if anything, and its tag "held:...".
void add_held_thing(SceneModel& scene, Figure& figure, RandomStream rng);

}  // namespace dualpixel::scenes
