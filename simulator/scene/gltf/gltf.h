#pragma once
#include <optional>
#include <string>

#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// Reads a glTF 2.0 file (.gltf or .glb) into a Scene; the environment is left empty.
///
/// Taken over: the default scene's node tree; triangles (lists, strips, fans; indexed or not) with normals, two UV
/// sets and vertex colors; sparse accessors; morph targets at their default weights; skins in the pose that the node
/// tree gives them; metallic-roughness materials with textures, emission, alpha mask (alpha blend is taken as a mask
/// at 0.5, with a warning); cameras; KHR_lights_punctual, KHR_texture_transform, KHR_materials_emissive_strength,
/// KHR_materials_unlit, KHR_mesh_quantization.
///
/// A primitive that several nodes use is stored once, with a placement for each of them, and may have up to 2^20 of
/// these in all. Copies in world space are made for nodes with a skin or morph weights of their own and for those that
/// an animation moves at `time_s`; for transforms that no instance could be traced through in float: singular, sheared
/// (scaled along other axes than those of a turned child) or smaller than a micrometer; and for primitives that emit,
/// so that light can be sampled from them, or that are so few or so small that copies take less memory. What is stored
/// must have at most 2^26 vertices and as many corners of triangles.
///
/// The file is hostile until checked: accessor and view ranges, index and vertex values, finite numbers, node cycles,
/// texture sizes; every URI must name a regular file inside the glTF file's own folder. Whatever fails, and every
/// unknown *required* extension, throws InputError with one line that names file, field, value and what is allowed.
///
/// With `time_s` all animations play at once, and nodes have their pose at that time: translation, rotation and scale,
/// step and linear interpolation; the first key before it, the last one after it. Morph weights and cubic splines are
/// ignored, with a warning. Without `time_s` all animations are, and not even checked.
Scene read_gltf(const std::string& path, std::optional<double> time_s = {});

/// The same from a file's bytes. `name` appears in messages; URIs of files are looked up in `folder`, none where it is
/// empty.
Scene read_gltf_bytes(const std::string& bytes, const std::string& name, const std::string& folder,
                      std::optional<double> time_s = {});

/// Hash of what the views of the file's buffers hold besides pictures: geometry, skins, animations. It stays where
/// other JSON, names, materials, pictures or another order of the views are written around the same views, as .glb or
/// as .gltf. It changes where a program divides the same numbers into other views, pads within them or writes them in
/// another format or order. Of a file that cannot be taken apart, or whose views overlap to more bytes than its buffers
/// have, the hash of its bytes. Throws InputError where it cannot be read.
std::string geometry_hash(const std::string& path);

}  // namespace dualpixel::simulator
