#pragma once
#include <cstdint>

#include "simulator/scene/gltf/files.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// The file's materials in their order, with the textures that they use decoded, then one default material (glTF's:
/// white, metallic 1, roughness 1) at index model.materials.size(). Fills scene.materials, scene.textures and
/// scene.warnings. Images must be PNG or JPEG of at most 16384 texels a side, 2^32 texels in all; those that
/// `texels_in_memory` are too few for are paged. Throws InputError.
void read_materials(const GltfFile& file, Scene& scene, std::int64_t texels_in_memory = std::int64_t{1} << 27);

}  // namespace dualpixel::simulator
