#pragma once
#include <map>
#include <string>
#include <vector>

#include "scenes/people/makehuman/asset_types.h"

namespace dualpixel::scenes {

/// A Wavefront OBJ file.
struct ObjMesh {
  std::vector<vec3> positions;
  TexturedMesh faces;  ///< of the group that was asked for, or of all
  std::map<std::string, std::vector<int>> group_vertices;
};

/// `kept`: the group whose faces are read; empty: all.
ObjMesh read_obj(const std::string& path, const std::string& kept);

}  // namespace dualpixel::scenes
