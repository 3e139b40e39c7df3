#include "simulator/scene_file_names.h"

#include <nlohmann/json.hpp>

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

/// The text at `key` of an object `part` of the document, or null.
std::string* text_at(json& document, const char* part, const char* key) {
  const auto object = document.find(part);
  if (object == document.end() || !object->is_object()) return nullptr;
  const auto found = object->find(key);
  return found != object->end() && found->is_string() ? found->get_ptr<std::string*>() : nullptr;
}

}  // namespace

void each_file_name(json& scene, const FileNameVisitor& visit) {
  if (!scene.is_object()) return;
  if (const auto gltf = scene.find("gltf"); gltf != scene.end() && gltf->is_string()) {
    visit(*gltf->get_ptr<std::string*>());
  }
  if (std::string* file = text_at(scene, "camera", "file")) visit(*file);
  if (scene.contains("lens")) each_file_name_of_lens(scene["lens"], visit);
  if (std::string* file = text_at(scene, "environment", "path")) visit(*file);
  std::string* lens = text_at(scene, "truth", "photograph_lens");
  if (lens != nullptr && *lens != "ideal" && *lens != "own") visit(*lens);
}

void each_file_name_of_lens(json& lens, const FileNameVisitor& visit) {
  if (!lens.is_object()) return;
  for (auto& [key, value] : lens.items()) {
    if ((key == "file" || key == "map") && value.is_string()) {
      visit(*value.get_ptr<std::string*>());
    } else {
      each_file_name_of_lens(value, visit);
    }
  }
}

}  // namespace dualpixel::simulator
