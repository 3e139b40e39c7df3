#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace dualpixel::simulator {

/// The extensions that are understood; any other one that a file requires is refused.
inline constexpr const char* kSupportedExtensions[] = {
    "KHR_lights_punctual",        "KHR_texture_transform",   "KHR_materials_emissive_strength",
    "KHR_materials_unlit",        "KHR_mesh_quantization",   "KHR_materials_ior",
    "KHR_materials_specular",     "KHR_materials_clearcoat", "KHR_materials_sheen",
    "KHR_materials_transmission", "KHR_materials_volume"};

/// Checks the JSON of a glTF 2.0 file: the type and range of every field that the reader uses, every reference from one
/// array into another, and that accessors lie within their views and views within their buffers. What passes can be
/// walked without further checks of structure; the values inside the buffers are checked as they are decoded.
/// `bin_bytes` is the size of a GLB's binary chunk, which is buffer 0 where that has no URI.
///
/// Throws InputError naming `file`, the JSON path, the value and what is allowed (glTF 2.0 specification, section 5).
void check_gltf(const nlohmann::json& root, const std::string& file, std::optional<std::size_t> bin_bytes);

/// Throws InputError "file: pointer: message".
[[noreturn]] void fail_gltf(const std::string& file, const std::string& pointer, const std::string& message);

}  // namespace dualpixel::simulator
