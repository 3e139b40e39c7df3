#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

void add_tie(SceneModel& scene, const Figure& figure, RandomStream& rng);
void add_scarf(SceneModel& scene, Figure& figure, RandomStream& rng);

}  // namespace dualpixel::scenes
