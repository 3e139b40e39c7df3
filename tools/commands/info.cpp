#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "datasets/plan/plan.h"
#include "evaluation/metrics/statistics.h"
#include "evaluation/report/calibration_page.h"
#include "evaluation/report/page.h"
#include "pipeline/portrait/result_io.h"
#include "scenes/people/data_set/read_people_set.h"
#include "simulator/lens/lens_file.h"
#include "simulator/scene/gltf/gltf.h"
#include "tools/commands/commands.h"

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

/// The corners of the box of all that is drawn, meters in glTF's world; null where nothing is.
json world_bounds(const simulator::Scene& scene) {
  glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
  for (const simulator::Mesh& mesh : scene.meshes) {
    const auto add = [&](const glm::mat4x3& world_from_mesh) {
      for (const glm::vec3& position : mesh.positions) {
        const glm::vec3 world = world_from_mesh * glm::vec4(position, 1);
        low = glm::min(low, world);
        high = glm::max(high, world);
      }
    };
    if (mesh.placements.empty()) add(glm::mat4x3(1));
    for (const simulator::Placement& placement : mesh.placements) add(placement.world_from_mesh);
  }
  if (low.x > high.x) return nullptr;
  return {{"low_m", {low.x, low.y, low.z}}, {"high_m", {high.x, high.y, high.z}}};
}

json describe_camera(const simulator::CameraNode& camera) {
  const glm::vec4 position = camera.world_from_node[3], forward = -camera.world_from_node[2];
  json description = {{"name", printable(camera.name)},
                      {"position_m", {position.x, position.y, position.z}},
                      {"looks_along", {forward.x, forward.y, forward.z}}};
  if (camera.vertical_fov_rad) description["vertical_fov_deg"] = *camera.vertical_fov_rad * 180 / M_PI;
  return description;
}

/// Names in the file's own list `key`: of its materials or its extensions.
json names_in(const nlohmann::json& root, const char* key) {
  json names = json::array();
  const auto list = root.find(key);
  if (list == root.end() || !list->is_array()) return names;
  for (const nlohmann::json& entry : *list) {
    const nlohmann::json name = entry.is_object() ? entry.value("name", nlohmann::json()) : entry;
    names.push_back(name.is_string() ? printable(name.get<std::string>()) : fmt::format("unnamed {}", names.size()));
  }
  return names;
}

/// The JSON of a glTF file that read_gltf has accepted: of a GLB its first chunk, whose length is the fourth word.
nlohmann::json gltf_json(const std::string& path) {
  constexpr std::size_t kLengthAt = 12, kTextAt = 20;
  const std::string bytes = read_file(path);
  if (!bytes.starts_with("glTF")) return parse_json(bytes, path);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + kLengthAt, sizeof(length));
  return parse_json(bytes.substr(kTextAt, length), path);
}

json describe_gltf(const std::string& path) {
  const simulator::Scene scene = simulator::read_gltf(path);
  std::size_t stored = 0, triangles = 0, person_triangles = 0;
  for (const simulator::Mesh& mesh : scene.meshes) {
    const auto persons = std::count_if(mesh.placements.begin(), mesh.placements.end(),
                                       [](const simulator::Placement& placement) { return placement.person; });
    const bool placed = !mesh.placements.empty();
    stored += mesh.triangles.size();
    triangles += mesh.triangles.size() * (placed ? mesh.placements.size() : 1);
    person_triangles += mesh.triangles.size() * (placed ? persons : mesh.person);
  }
  json cameras = json::array();
  for (const simulator::CameraNode& camera : scene.cameras) cameras.push_back(describe_camera(camera));
  json warnings = json::array();
  for (const std::string& warning : scene.warnings) warnings.push_back(printable(warning));
  const nlohmann::json root = gltf_json(path);
  return {{"kind", "glTF scene"},
          {"bounds", world_bounds(scene)},
          {"meshes", scene.meshes.size()},
          {"triangles", triangles},
          {"stored_triangles", stored},
          {"person_triangles", person_triangles},
          {"materials", names_in(root, "materials")},
          {"textures", scene.textures.size()},
          {"lights", scene.lights.size()},
          {"cameras", cameras},
          {"extensions", names_in(root, "extensionsUsed")},
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

/// A JSON file by what it holds: a scene names its glTF file and its camera, a lens its model or another lens. Files of
/// a folder that is written as a whole are named by their format, which is checked with the folder.
json describe_json(const std::string& path) {
  const nlohmann::json document = read_json_file(path);
  json description = {{"kind", "JSON"}};
  if (document.contains("asset")) return describe_gltf(path);
  if (document.contains("camera") || document.contains("gltf")) description["kind"] = "scene";
  // the JSON that `dualpixel lens` prints has a model, too, but no version
  if (document.contains("version") && (document.contains("model") || document.contains("file"))) {
    simulator::read_lens_file(path, std::numeric_limits<double>::infinity());  // throws where it is not a lens
    description["kind"] = "lens";
  }
  if (document.contains("format")) {
    if (document["format"] == "dualpixel-result") description["kind"] = "portrait result";
    if (document["format"] == "dualpixel-capture") description["kind"] = "file of a capture; give its folder";
  }
  for (const auto& [key, value] : document.items()) description.emplace(key, value);
  return description;
}

json describe_calibration(const std::string& path) {
  const pipeline::Calibration calibration = evaluation::read_calibration_folder(path);
  const Camera& camera = calibration.camera;
  json focuses = json::array();
  std::vector<float> residuals;
  std::size_t lines = 0, nodes = 0;
  double least_r_squared = 1;
  for (const pipeline::FocusCalibration& f : calibration.focuses) {
    least_r_squared = std::min(least_r_squared, f.r_squared);
    focuses.push_back(std::isinf(f.focus_distance_m) ? json("inf") : json(f.focus_distance_m));
    nodes += f.slope_dp_px_m.data.size();
    for (std::size_t i = 0; i < f.slope_dp_px_m.data.size(); ++i) {
      if (f.slope_dp_px_m.data[i] == 0) continue;
      residuals.push_back(f.residual_dp_px.data[i]);
      ++lines;
    }
  }
  return {{"kind", "calibration"},
          {"camera", camera.name},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"view_width_px", camera.dp_width()},
          {"view_height_px", camera.dp_height()},
          {"focal_length_mm", camera.focal_length_mm},
          {"f_number", camera.f_number},
          {"focus_distances_m", focuses},
          {"nearest_target_m", calibration.nearest_target_m},
          {"farthest_target_m", calibration.farthest_target_m},
          {"fitted_position_share", static_cast<double>(lines) / static_cast<double>(nodes)},
          {"median_residual_dp_px", evaluation::median(std::move(residuals))},
          {"least_r_squared", least_r_squared},
          {"has_kernel_skew", !calibration.focuses.front().skew.nodes.empty()},
          {"warnings", calibration.warnings}};
}

json describe_people(const std::string& path) {
  const std::string index = path + "/" + scenes::kSetFile;
  bool held_out = false, faces = false;
  if (fs::exists(index)) {
    const nlohmann::json document = read_json_file(index);
    Fields(document, index).required("held_out").boolean("held_out", held_out).boolean("faces", faces);
  }
  const scenes::PeopleSet set({path}, held_out, faces ? scenes::PeopleSetKind::faces : scenes::PeopleSetKind::masks);
  scenes::require_unchanged(path);
  std::size_t composites = 0, groups = 0;
  for (std::size_t i = 0; i < set.size(); ++i) {
    composites += set[i].composite;
    groups += set[i].people > 1;
  }
  json description = {{"kind", "people set"}};
  const nlohmann::json document = read_json_file(index);
  for (const auto& [key, value] : document.items()) description.emplace(key, value);
  description["composite_samples"] = composites;
  description["samples_of_groups"] = groups;
  return description;
}

json describe(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    if (fs::exists(path + "/capture.json", error)) return describe_capture(path);
    if (fs::exists(path + "/result.json", error)) {
      pipeline::read_result(path);  // verifies its pictures
      return describe_json(path + "/result.json");
    }
    if (fs::exists(path + "/calibration.json", error)) return describe_calibration(path);
    if (fs::exists(path + "/" + scenes::kSetFile, error) || fs::exists(path + "/shard_00000", error)) {
      return describe_people(path);
    }
    if (fs::exists(path + "/" + datasets::kDatasetFile, error)) {
      throw InputError(printable(path) + ": is a data set: 'dualpixel dataset status' and 'verify' tell of it");
    }
    throw InputError(printable(path) +
                     ": is a folder without capture.json, result.json, calibration.json or people.json");
  }
  char head[4] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof(head));
  if (std::string(head, 4) == "glTF" || extension_of(path) == ".gltf") return describe_gltf(path);
  if (fs::path(path).extension() == ".json") return describe_json(path);
  return describe_picture(path);
}

std::string text_of(const json& value) {
  return printable(value.is_string() ? value.get<std::string>() : value.dump());
}

bool holds_objects(const json& value) { return value.is_array() && !value.empty() && value.front().is_object(); }

/// One line for each object of an array, its name first: "blur: ms 12, peak_rss_mb 540".
void print_rows(const json& rows, const std::string& indent) {
  for (const json& row : rows) {
    std::string line = row.contains("name") ? text_of(row["name"]) + ":" : "";
    const char* separator = line.empty() ? "" : " ";
    for (const auto& [key, entry] : row.items()) {
      if (key == "name") continue;
      line += fmt::format("{}{} {}", separator, printable(key), text_of(entry));
      separator = ", ";
    }
    fmt::print("{}{}\n", indent, line);
  }
}

void print(const json& value, const std::string& indent) {
  for (const auto& [key, entry] : value.items()) {
    const std::string name = printable(key);
    if (entry.is_object() && !entry.empty()) {
      fmt::print("{}{}\n", indent, name);
      print(entry, indent + "  ");
    } else if (holds_objects(entry)) {
      fmt::print("{}{}\n", indent, name);
      print_rows(entry, indent + "  ");
    } else {
      fmt::print("{}{:<{}} {}\n", indent, name, 26 - static_cast<int>(indent.size()), text_of(entry));
    }
  }
}

struct InfoOptions {
  std::string path;
  std::string page;
  bool as_json = false;
};

}  // namespace

void add_info(CLI::App& program) {
  CLI::App* command = program.add_subcommand("info", "Say what a file or folder is, and verify it");
  const auto options = std::make_shared<InfoOptions>();
  command
      ->add_option(
          "path", options->path,
          "Folder of a capture, a result, a calibration or a people set; scene or lens JSON, glTF file or picture")
      ->required();
  command->add_option("-o,--output", options->page, "Write a page with the lines and maps of a calibration")
      ->type_name("PAGE.html");
  command->add_flag("--json", options->as_json, "Print JSON");
  command->footer(
      "Example:\n  dualpixel info out/capture --json\n  dualpixel info out/calibration -o calibration.html");
  command->callback([options] {
    const json description = describe(options->path);
    if (!options->page.empty()) {
      if (description["kind"] != "calibration") {
        throw InputError(printable(options->path) + ": -o: pages are made of calibrations only");
      }
      evaluation::write_page(options->page, evaluation::to_page(evaluation::read_calibration_folder(options->path),
                                                                evaluation::read_measurements(options->path)));
    }
    if (options->as_json) {
      std::cout << description.dump(2) << '\n';
    } else {
      print(description, "");
    }
  });
}

}  // namespace dualpixel::tools
