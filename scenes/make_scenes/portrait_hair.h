#pragma once
#include "scenes/gltf/mesh.h"

/// Hair of the default scene's person, in the face's coordinates (portrait_face.h).
namespace dualpixel::scenes {

/// Signed distance of what lies under the strands.
float scalp(glm::vec3 p);

/// Thin ribbons that grow from the scalp, fall and stray.
Mesh hair_strands();

Mesh brow_hairs();

/// Along the upper lids.
Mesh lashes();

}  // namespace dualpixel::scenes
