#pragma once
#include <string>

#include "capture/capture.h"
#include "simulator/ready_scene.h"

/// What the camera of a scene file sees through a pinhole, in a picture of 64 columns: enough to focus by.
namespace dualpixel::scenes {

Truth seen_surfaces(const simulator::Simulation& simulation, const simulator::ReadyScene& ready);

/// Depth at the place of the picture, in shares of its sides, or at the nearest place that sees anything. Throws
/// InputError where the camera sees no surface; `field` names what asked.
double depth_at(const Truth& seen, double x, double y, const std::string& path, const char* field);

/// The median depth of what is seen of the glTF node's mesh. Throws InputError where there is no such node, or nothing
/// of it is seen.
double depth_of_node(const Truth& seen, const std::string& node, const simulator::ReadyScene& ready,
                     const std::string& path, const char* field);

}  // namespace dualpixel::scenes
