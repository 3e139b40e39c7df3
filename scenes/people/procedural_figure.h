#pragma once
#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {

/// Draws a person and adds it to the scene: body, clothes, hair, head, what it holds and its seat. Nothing is read.
Figure add_figure(SceneModel& scene, RandomStream rng, const FigureOptions& options);

}  // namespace dualpixel::scenes
