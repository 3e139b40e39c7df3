#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "datasets/recipe/recipe.h"

namespace dualpixel::datasets {

/// What the scenes of an entry of the recipe, or of a file, have in common.
struct SceneOrigin {
  nlohmann::json scene;       ///< as SampleLine::scene; of a kind without its seed
  nlohmann::json scene_file;  ///< of it; of a kind what is known before a scene is drawn
  std::string path;           ///< of the scene file; of a kind its name
  std::string geometry;       ///< names it among others; of a kind its name
  bool one_model = false;     ///< of a kind: all seeds show the same
  std::string environment;    ///< hash of the picture that lights it, where one of its own does
};

/// A scene that samples can be made of. There may be many: what they share is stored once.
struct Asset {
  std::shared_ptr<const SceneOrigin> origin;
  std::optional<std::uint64_t> seed;  ///< of a drawn scene
  double weight = 1;

  nlohmann::json scene() const;  ///< as SampleLine::scene
  std::string path() const;      ///< of the scene file; of a drawn scene only its name
  std::string geometry() const;  ///< names it among others: copies of a model have the same
};

/// What each split draws from; no two splits share geometry or an environment.
struct SplitAssets {
  std::vector<Asset> scenes;
  std::vector<double> ends;  ///< running sum of the scenes' weights
  std::vector<std::string> environments;

  /// The scene at a share in [0, 1) of all weights.
  const Asset& scene_at(double share) const;
};
using Assets = std::array<SplitAssets, kSplitCount>;

/// Reads the files that the recipe names; `warnings` gets a line for each folder of which files were left out. Throws
/// InputError, also where there are fewer groups of scenes, or fewer environments, than splits.
Assets gather_assets(const Recipe& recipe, std::vector<std::string>& warnings);

/// What the scene of a file is known by: a scene file and its glTF file, or a glTF file alone.
std::string scene_hash(const std::string& file, const nlohmann::json& scene_file);

/// How many of `things` each split gets, by its share: each that has one gets one at least. Needs as many things as
/// splits.
std::array<std::size_t, kSplitCount> split_counts(std::size_t things, const std::array<double, kSplitCount>& shares);

}  // namespace dualpixel::datasets
