#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

void add_beard(SceneModel& scene, Figure& figure, RandomStream& rng);
void add_glasses(SceneModel& scene, Figure& figure, RandomStream& rng);

}  // namespace dualpixel::scenes
