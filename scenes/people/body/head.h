#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// The head without hair, in its own frame at scale 1, meters. Each parameter scales one feature.
struct HeadShape {
  float jaw = 1, cheeks = 1, nose = 1, nose_length = 1, lips = 1, brow = 1, chin = 1, long_face = 1, lids = 1, ears = 1;
  float operator()(vec3 p) const;
};

/// Moves an object from the head's frame, at scale 1, to the world; rest stays.
void move_to_head(const Figure& figure, SceneObject& object);

void add_head(SceneModel& scene, Figure& figure, RandomStream rng);

}  // namespace dualpixel::scenes
