#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/recipe/recipe.h"

namespace dualpixel::datasets {

/// A scene that samples can be made of.
struct Asset {
  nlohmann::json scene;       ///< as SampleLine::scene
  nlohmann::json scene_file;  ///< of it; of a drawn scene what is known before it is drawn
  std::string path;           ///< of the scene file; of a drawn scene only its name
  std::string identity;       ///< of its geometry: assets of one identity are in one split
  double weight = 1;
};

/// What each split draws from; no two splits share geometry or an environment.
struct SplitAssets {
  std::vector<Asset> scenes;
  std::vector<std::string> environments;
};
using Assets = std::array<SplitAssets, kSplitCount>;

/// Reads the files that the recipe names. Throws InputError, also where there are fewer scenes or environments than
/// splits.
Assets gather_assets(const Recipe& recipe);

/// What the scene of a file is known by: a scene file and its glTF file, or a glTF file alone.
std::string scene_hash(const std::string& file, const nlohmann::json& scene_file);

/// How many of `things` each split gets, by its share: each that has one gets one at least. Needs as many things as
/// splits.
std::array<std::size_t, kSplitCount> split_counts(std::size_t things, const std::array<double, kSplitCount>& shares);

}  // namespace dualpixel::datasets
