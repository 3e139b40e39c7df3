#pragma once
#include <cstdint>
#include <span>

#include "simulator/scene/gltf/files.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// Decodes the file's image images[i] into textures[i], on all threads. PNG or JPEG of 1 to 4 channels (gray, gray and
/// alpha, RGB, RGBA), at most 16384 texels a side, 2^32 texels in all; those that `texels_in_memory` are too few for
/// are paged. Throws InputError, of several faults that of the first of `images`; what headers and checksums show comes
/// before what decoding shows.
void decode_images(const GltfFile& file, std::span<const int> images, std::span<Texture> textures,
                   std::int64_t texels_in_memory);

}  // namespace dualpixel::simulator
