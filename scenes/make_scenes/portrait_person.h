#pragma once
#include "scenes/gltf/glb.h"

namespace dualpixel::scenes {

/// The person of the default scene: head and shoulders, one hand raised, .86 m in front of a camera at the origin that
/// looks along -z.
void add_portrait_person(Glb& glb);

}  // namespace dualpixel::scenes
