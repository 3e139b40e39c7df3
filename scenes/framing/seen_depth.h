#pragma once
#include <string>

#include "simulator/ready_scene.h"

/// How far away the surfaces are that the camera of a scene file sees, in a picture of 64 columns: enough to focus by.
namespace dualpixel::scenes {

/// Depth, m, at the place of the picture, in shares of its sides, or at the nearest place that sees anything. Throws
/// InputError where the camera sees no surface; `field` names what asked.
double seen_depth(const simulator::Simulation& simulation, const simulator::ReadyScene& ready, double x, double y,
                  const std::string& path, const char* field);

/// The median depth, m, of what is seen of the glTF node's mesh. Throws InputError where there is no such node, or
/// nothing of it is seen.
double seen_depth_of_node(const simulator::Simulation& simulation, const simulator::ReadyScene& ready,
                          const std::string& node, const std::string& path, const char* field);

}  // namespace dualpixel::scenes
