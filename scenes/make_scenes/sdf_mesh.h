#pragma once
#include <functional>

#include "scenes/gltf/glb.h"

namespace dualpixel::scenes {

/// A signed distance, meters, negative inside.
using Sdf = std::function<float(glm::vec3)>;

/// The functions of procedural/signed_distance.h, not inlined: with constant arguments the compiler would round some
/// products differently, and change the bytes of the shipped glTF files.
float sdf_ellipsoid(glm::vec3 p, glm::vec3 center, glm::vec3 radii);
float sdf_capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b);
float sdf_union(float a, float b, float k);
float sdf_subtract(float a, float b, float k);

/// The zero surface inside the box, by surface nets (Gibson 1998) on cells of `cell_m`, with smooth normals. UVs wrap
/// around the vertical axis through the middle of the box: one repeat per `texture_m` meters.
Mesh mesh_sdf(const Sdf& sdf, glm::vec3 low, glm::vec3 high, float cell_m, float texture_m);

}  // namespace dualpixel::scenes
