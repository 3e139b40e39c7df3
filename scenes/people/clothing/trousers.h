#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// Trousers or a skirt, and shoes.
void add_trousers(SceneModel& scene, Figure& figure, RandomStream& rng);

}  // namespace dualpixel::scenes
