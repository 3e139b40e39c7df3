#pragma once
#include "simulator/scene/gltf_files.h"

namespace dualpixel::simulator {

/// Puts every node that an animation moves where it is at `time_s`, as read_gltf() says; `file` was loaded with its
/// animations. Throws InputError where times don't increase, numbers are not finite, or a quaternion is 0.
void pose_nodes(GltfFile& file, double time_s);

}  // namespace dualpixel::simulator
