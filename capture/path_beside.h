#pragma once
#include <filesystem>
#include <string>

namespace dualpixel {

/// The path of a file that a JSON file names: relative to that file's folder, unless absolute.
inline std::string path_beside(const std::string& json_path, const std::string& name) {
  return (std::filesystem::path(json_path).parent_path() / name).string();
}

}  // namespace dualpixel
