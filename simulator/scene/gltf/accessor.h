#pragma once
#include <cstdint>
#include <vector>

#include "simulator/scene/gltf/files.h"

/// Decoding accessors whose ranges check_gltf has passed: strides, component types, normalized integers, sparse
/// replacements. All components of an element are adjacent in the result.
namespace dualpixel::simulator {

/// Any component type as float; normalized integers become -1..1 or 0..1. Throws InputError on NaN and infinity.
std::vector<float> read_floats(const GltfFile& file, int accessor);

/// Unsigned integers. Throws InputError on values that are not less than `end`; `meaning` says what they count.
std::vector<std::uint32_t> read_indices(const GltfFile& file, int accessor, std::size_t end, const char* meaning);

}  // namespace dualpixel::simulator
