#pragma once
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// Scales the scene about the world's origin, cameras and lamps included, so that the longest side of its box is
/// `longest_m`. Lamps shine as much brighter as things are farther from them. A scene without triangles stays.
void scale_to(Scene& scene, double longest_m);

}  // namespace dualpixel::simulator
