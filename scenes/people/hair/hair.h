#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// Hair, at times under a hat, beard and glasses, with their tags.
void add_hair_and_hat(SceneModel& scene, Figure& figure, RandomStream rng);

}  // namespace dualpixel::scenes
