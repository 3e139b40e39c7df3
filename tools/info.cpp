#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/image_io.h"
#include "capture/json_fields.h"
#include "simulator/scene/gltf.h"
#include "tools/commands.h"

namespace dualpixel::tools {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

json describe_capture(const std::string& path) {
  const Capture capture = read_capture(path, true);  // verifies every file on the way
  json document = json::parse(nlohmann::json(read_json_file(path + "/capture.json")).dump());
  json frames = {{"count", capture.frames.size()},
                 {"mosaic", !capture.frames.front().mosaic.empty()},
                 {"dp_width_px", capture.camera.dp_width()},
                 {"dp_height_px", capture.camera.dp_height()}};
  json description = {{"kind", "capture"},
                      {"version", document["version"]},
                      {"camera", document["camera"]},
                      {"exposure", document["exposure"]},
                      {"frames", frames},
                      {"truth", capture.truth.has_value()},
                      {"manifest", document.contains("files") ? "verified" : "absent"}};
  if (document.contains("provenance")) description["provenance"] = document["provenance"];
  return description;
}

json describe_gltf(const std::string& path) {
  const simulator::Scene scene = simulator::read_gltf(path);
  std::size_t triangles = 0, person_triangles = 0;
  for (const simulator::Mesh& mesh : scene.meshes) {
    triangles += mesh.triangles.size();
    if (mesh.person) person_triangles += mesh.triangles.size();
  }
  json cameras = json::array();
  for (const simulator::CameraNode& camera : scene.cameras) cameras.push_back(printable(camera.name));
  json warnings = json::array();
  for (const std::string& warning : scene.warnings) warnings.push_back(printable(warning));
  return {{"kind", "glTF scene"},
          {"meshes", scene.meshes.size()},
          {"triangles", triangles},
          {"person_triangles", person_triangles},
          {"materials", scene.materials.size()},
          {"textures", scene.textures.size()},
          {"lights", scene.lights.size()},
          {"cameras", cameras},
          {"warnings", warnings}};
}

json describe_picture(const std::string& path) {
  const PictureSize size = picture_size(path);
  return {{"kind", "picture"},
          {"format", size.format},
          {"width_px", size.width},
          {"height_px", size.height},
          {"channels", size.channels}};
}

/// A JSON file by what it holds: a scene names its glTF file and its camera.
json describe_json(const std::string& path) {
  const nlohmann::json document = read_json_file(path);
  json description = {{"kind", "JSON"}};
  if (document.contains("asset")) return describe_gltf(path);
  if (document.contains("camera") || document.contains("gltf")) description["kind"] = "scene";
  if (document.contains("mode") && document.contains("stages")) description["kind"] = "portrait result";
  for (const auto& [key, value] : document.items()) description[key] = value;
  return description;
}

json describe(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    if (fs::exists(path + "/capture.json", error)) return describe_capture(path);
    if (fs::exists(path + "/result.json", error)) return describe_json(path + "/result.json");
    throw InputError(printable(path) + ": is a folder without capture.json or result.json");
  }
  char head[4] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof(head));
  if (std::string(head, 4) == "glTF" || fs::path(path).extension() == ".gltf") return describe_gltf(path);
  if (fs::path(path).extension() == ".json") return describe_json(path);
  return describe_picture(path);
}

void print(const json& value, const std::string& indent) {
  for (const auto& [key, entry] : value.items()) {
    const std::string name = printable(key);
    if (entry.is_object() && !entry.empty()) {
      fmt::print("{}{}\n", indent, name);
      print(entry, indent + "  ");
    } else {
      const std::string text = entry.is_string() ? entry.get<std::string>() : entry.dump();
      fmt::print("{}{:<{}} {}\n", indent, name, 26 - static_cast<int>(indent.size()), printable(text));
    }
  }
}

struct InfoOptions {
  std::string path;
  bool as_json = false;
};

}  // namespace

void add_info(CLI::App& program) {
  CLI::App* command = program.add_subcommand("info", "Says what a file or folder is, and verifies it");
  const auto options = std::make_shared<InfoOptions>();
  command->add_option("path", options->path, "Capture or result folder, scene JSON, glTF file or picture")->required();
  command->add_flag("--json", options->as_json, "Print JSON");
  command->footer("Example:\n  dualpixel info out/capture --json");
  command->callback([options] {
    const json description = describe(options->path);
    if (options->as_json) {
      std::cout << description.dump(2) << '\n';
    } else {
      print(description, "");
    }
  });
}

}  // namespace dualpixel::tools
