#pragma once
#include "scenes/people/body/figure.h"
#include "scenes/people/hair/hair_shape.h"

namespace dualpixel::scenes {

/// Adds a random hat and flattens the hair under it. Returns whether it hides all hair.
bool add_hat(SceneModel& scene, Figure& figure, RandomStream& rng, HairShape& hair);

}  // namespace dualpixel::scenes
