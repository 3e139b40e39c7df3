#pragma once
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// Of the box of all points that triangles and strands use, in the world, meters; 0 without any.
float longest_side(const Scene& scene);

/// Scales the scene about the world's origin, cameras and lamps included, so that the longest side of its box is
/// `longest_m`. Lamps shine as much brighter as things are farther from them. A scene without triangles stays.
void scale_to(Scene& scene, double longest_m);

}  // namespace dualpixel::simulator
