#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// A seat under a sitting person; it belongs to the environment.
void add_seat(SceneModel& scene, const Figure& figure, RandomStream rng);

}  // namespace dualpixel::scenes
