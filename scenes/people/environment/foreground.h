#pragma once
#include "scenes/people/shape/scene_model.h"

namespace dualpixel::scenes {

/// Adds something between the camera and the people: the edge of a table, leaves, a rail. `camera`: its position; the
/// object reaches up to about `top_m`.
void add_foreground(SceneModel& scene, RandomStream rng, vec3 camera, float top_m);

}  // namespace dualpixel::scenes
