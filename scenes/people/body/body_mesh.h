#pragma once
#include <cstdint>

#include "scenes/people/body/figure.h"

/// Skin and cloth as meshes on the posed body.
namespace dualpixel::scenes {

/// The surface of a shape minus the cones in `carved`, with rest positions of the body and folds of `folds_m`.
SceneObject mesh_on_body(const Figure& figure, const Shape& shape, float folds_m, std::uint32_t seed,
                         const std::vector<Cone>& carved = {}, float carve_fillet_m = 0.01f);

/// Skin of torso, neck and limbs, and the hands.
void add_body(SceneModel& scene, Figure& figure);

}  // namespace dualpixel::scenes
