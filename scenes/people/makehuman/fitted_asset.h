#pragma once
#include <string>

#include "scenes/people/makehuman/asset_types.h"

namespace dualpixel::scenes {

/// Reads a .mhclo file, its mesh and its texture. `base_vertices`: of the mesh that it is fitted to.
FittedAsset read_fitted(const std::string& path, int base_vertices);

}  // namespace dualpixel::scenes
