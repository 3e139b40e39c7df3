#pragma once
#include <cstdint>

#include "simulator/scene/gltf/files.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// The file's materials in their order, with the textures that they use decoded, then one default material (glTF's:
/// white, metallic 1, roughness 1) at index model.materials.size(). Fills scene.materials, scene.textures and
/// scene.warnings. Images as decode_images() takes them. Throws InputError.
void read_materials(const GltfFile& file, Scene& scene, std::int64_t texels_in_memory = std::int64_t{1} << 27);

}  // namespace dualpixel::simulator
