#pragma once
#include <string>
#include <vector>

#include "scenes/people/body/figure.h"
#include "scenes/people/makehuman/motion.h"

namespace dualpixel::scenes {

/// A figure that is being dressed.
struct Dressing {
  SceneModel& scene;
  Figure& figure;
  const MorphedBody& morphed;
  const std::vector<PartMotion>& motion;
  std::vector<vec3> posed;   ///< of the base mesh
  std::vector<bool> hidden;  ///< base mesh vertices that clothes cover
};

/// A mesh with posed vertices as an object, without the triangles whose vertices are `hidden` or all below `lowest_m`;
/// normals are smooth across texture seams. rest: texture coordinates where it is `textured`, else `rest`.
SceneObject mesh_object(const TexturedMesh& mesh, const std::vector<vec3>& posed, const std::vector<vec3>& rest,
                        bool textured, const std::vector<bool>& hidden, float lowest_m);

/// The asset's texture tinted so that its mean becomes `color`; plain where it has none.
Material tinted(const FittedAsset& asset, vec3 color, bool cut_out);

/// Adds a fitted asset, `grow_m` larger.
void add_fitted(Dressing& dressing, const FittedAsset& asset, const Material& material, float grow_m = 0);

/// Trousers and a top that follow the body at a small distance.
void add_shell_clothes(Dressing& dressing, RandomStream& rng);

}  // namespace dualpixel::scenes
