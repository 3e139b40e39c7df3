#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "simulator/scene/gltf/files.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

inline constexpr double kFarthestVertex_m = 1e6;  ///< from the origin
inline constexpr double kThinnestHair_m = 1e-9;   ///< radius

/// Pose of a mesh: the world matrix of its node, or, for a skinned mesh (whose node's own matrix does not count),
/// each joint's world matrix times its inverse bind matrix.
struct MeshPose {
  glm::dmat4 world_from_mesh{1};
  std::vector<glm::dmat4> world_from_bind;  ///< empty: not skinned
};

/// One primitive of a glTF mesh in world space, morphed by `weights` (one for each target, or none), as a list of
/// triangles whose winding agrees with the normals even where the pose mirrors. Triangles without area are left out;
/// `zero_area` counts them. Lines with a width at each vertex (attribute _WIDTH, meters of the mesh) are strands of
/// hair; of other lines and points the result has none. Material, object and person are left to
/// the caller. Throws InputError on indices beyond the vertices or joints, non-finite values, vertices more than 1e6 m
/// from the origin, and radii of hair beyond 1e-9 to 1e6 m.
Mesh read_primitive(const GltfFile& file, int mesh, int primitive, const std::vector<double>& weights,
                    const MeshPose& pose, std::size_t& zero_area);

/// The same of a primitive of triangles that several nodes place, once for all of them: in coordinates of its own, in
/// which its box has its middle at 0 and a longest side of 1 to 2, so that neither the file's units nor its origin cost
/// precision. `file_from_own` leads back to the file's.
Mesh read_shared_primitive(const GltfFile& file, int mesh, int primitive, const std::vector<double>& weights,
                           glm::dmat4& file_from_own, std::size_t& zero_area);

}  // namespace dualpixel::simulator
