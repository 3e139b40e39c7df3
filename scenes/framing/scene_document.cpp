#include "scenes/framing/scene_document.h"

#include <fmt/format.h>

#include <filesystem>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"

namespace dualpixel::scenes {

using nlohmann::json;

bool is_gltf(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".glb" || extension == ".gltf";
}

json read_scene_document(const std::string& path) {
  if (is_gltf(path)) return {{"version", 1}, {"gltf", std::filesystem::path(path).filename().string()}};
  json document = read_json_file(path);
  if (document.is_object() && document.contains("kind") && !document.contains("gltf")) {
    throw InputError(
        fmt::format("{}: is a definition: draw its scene first, by `dualpixel scene FILE -o DIR`", printable(path)));
  }
  return document;
}

void set_pose(json& scene_file, const std::array<double, 3>& position_m, const std::array<double, 3>& look_at_m) {
  json& camera = scene_file["camera"];
  if (camera.is_object()) camera.erase("node");
  camera["position_m"] = position_m;
  camera["look_at_m"] = look_at_m;
  camera["up"] = {0, 1, 0};
}

double short_number(double value) {
  constexpr int kDigits = 4;
  return std::stod(fmt::format("{:.{}g}", value, kDigits));
}

}  // namespace dualpixel::scenes
