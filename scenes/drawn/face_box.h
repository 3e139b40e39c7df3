#pragma once
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "simulator/scene_file.h"

namespace dualpixel::scenes {

/// A scene file's `face_px`: the box about `outline`, points of the world, as a pinhole at the lens's image distance
/// shows it to a camera at `eye` that looks along `forward`, upright; a lens's distortion is left out. Null where the
/// box is not whole in the picture.
nlohmann::json face_box(const std::vector<glm::vec3>& outline, glm::vec3 eye, glm::vec3 forward,
                        const simulator::Simulation& simulation);

/// The box of a camera that looks from the same place through another lens, at another distance of focus, or on another
/// sensor than that of `before`, whose `face_px` it follows from. Null where the place, or the size of what is seen, is
/// another, and where the box is not whole in the picture.
nlohmann::json face_box_after(const simulator::Simulation& before, const simulator::Simulation& after);

}  // namespace dualpixel::scenes
