#pragma once
#include <functional>

#include "scenes/make_scenes/glb.h"

namespace dualpixel::scenes {

/// A signed distance, metres, negative inside.
using Sdf = std::function<float(glm::vec3)>;

float ellipsoid(glm::vec3 p, glm::vec3 centre, glm::vec3 radii);
float capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b);
/// Union and subtraction with a fillet of about k metres.
float smooth_union(float a, float b, float k);
float smooth_subtract(float a, float b, float k);

/// The zero surface inside the box, by surface nets (Gibson 1998) on cells of `cell_m`, with smooth normals. UVs wrap
/// around the vertical axis through the box's middle: one repeat each `texture_m` metres.
Mesh mesh_sdf(const Sdf& sdf, glm::vec3 low, glm::vec3 high, float cell_m, float texture_m);

}  // namespace dualpixel::scenes
