#pragma once
#include "scenes/people/body/figure.h"
#include "scenes/people/makehuman/assets.h"

namespace dualpixel::scenes {

/// Draws a person and adds it to the scene, as add_figure() does, from assets.
Figure add_makehuman_figure(SceneModel& scene, const MakeHumanAssets& assets, RandomStream rng,
                            const FigureOptions& options);

}  // namespace dualpixel::scenes
