#pragma once
#include "scenes/gltf/glb.h"

namespace dualpixel::scenes {

/// A fronto-parallel plane of band-limited texture at 0.88 m: no detail finer than about 8 photosites of the default
/// camera, so that nothing aliases. This and the others: with a camera at the origin.
void add_calibration_target(Glb& glb);
/// Textured planes, slanted about both axes, from 0.35 to 2 m.
void add_slanted_planes(Glb& glb);
/// Cards, combs and rods of many widths, in front of each other.
void add_occlusion_edges(Glb& glb);

}  // namespace dualpixel::scenes
