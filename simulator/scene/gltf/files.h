#pragma once
#include <tiny_gltf.h>

#include <string>
#include <vector>

namespace dualpixel::simulator {

/// A glTF file whose structure check_gltf has passed, with all of its buffers in memory. Images are still encoded:
/// tinygltf::Image::image holds the bytes of the PNG or JPEG.
struct GltfFile {
  std::string name;  ///< as messages name it
  tinygltf::Model model;
  std::vector<std::string> warnings;
  std::string source_hash;  ///< of the file's bytes and of those that its URIs name
};

/// Takes the container apart (GLB header and chunks), checks the JSON, and reads what the URIs name: data URIs, and
/// regular files that lie, links resolved, in `folder` or below it. An empty `folder` allows no files.
/// tinygltf never opens a file itself: it is given JSON in which every URI is a key of what was read here.
/// Without `with_animations` they are left out, with a warning. Throws InputError.
GltfFile load_gltf(const std::string& bytes, const std::string& name, const std::string& folder, bool with_animations);

/// As geometry_hash() in gltf.h; the hash of the file's bytes where it cannot be taken apart.
std::string hash_of_geometry(const std::string& bytes, const std::string& name, const std::string& folder);

}  // namespace dualpixel::simulator
