#pragma once
#include <vector>

#include "simulator/scene/gltf/files.h"

namespace dualpixel::simulator {

/// Puts every node that an animation moves where it is at `time_s`, as read_gltf() says; `file` was loaded with its
/// animations. Returns for each node whether it is one of those. Throws InputError where times don't increase, numbers
/// are not finite, or a quaternion is 0.
std::vector<bool> pose_nodes(GltfFile& file, double time_s);

}  // namespace dualpixel::simulator
