#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// A top, trousers or a skirt, shoes and at times a scarf, with their tags.
void add_clothes(SceneModel& scene, Figure& figure, RandomStream rng);

}  // namespace dualpixel::scenes
