#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/recipe/recipe.h"
#include "scenes/drawn/draw_scene.h"

namespace dualpixel::datasets {

/// A line of plan.jsonl: all that a sample's content depends on (docs/dataset.md).
struct SampleLine {
  int index = 0;
  std::string name;  ///< of its folder: the index with six digits or more
  Split split = Split::train;
  /// {"file": scene or glTF file, "xxh64": of it and of its glTF file}, or {"kind", "seed", "set"} of a drawn scene.
  nlohmann::json scene;
  std::uint64_t seed = 0;    ///< of rendering and noise
  nlohmann::json set;        ///< fields of the scene file by name, as `simulate --set` has them
  nlohmann::json relations;  ///< numbers drawn for what depends on what the camera sees
  Layout layout = Layout::exr;
  std::vector<std::string> keep;  ///< names of pictures
};

/// Of a sample and its folder.
std::string sample_name(int index);

/// One line of text, without its end.
std::string to_text(const SampleLine& line);

/// Throws InputError that names `where`.
SampleLine read_sample_line(const std::string& text, const std::string& where);

/// What a drawn scene (SampleLine::scene) is drawn by.
scenes::SceneOrder order_of(const nlohmann::json& scene);

/// A scene file's JSON with `set` and the seed applied. Throws InputError.
nlohmann::json with_set(nlohmann::json scene, const SampleLine& line);

}  // namespace dualpixel::datasets
