#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// Moves hair from the head's frame to the world. Below the chin it hangs from the body, not from the head, and lies on
/// the shoulders, not in them.
void let_hang(const Figure& figure, SceneObject& object);

/// Thin ribbons that leave the surface of `hair`: the soft edge of real hair.
SceneObject strands(const Figure& figure, const SceneObject& hair, RandomStream& rng, int count, float length_m,
                    float lift, float width_m, float curl);

}  // namespace dualpixel::scenes
