#pragma once
#include <string>

namespace dualpixel::scenes {

/// The default scene: a bust of a person 0.8 m from the camera on a garden terrace, with a plant nearer than the focus
/// plane and wall, hedge, trees and leaves behind it, out to 14 m. Nodes of the person are marked as such.
void make_portrait(const std::string& path);

}  // namespace dualpixel::scenes
