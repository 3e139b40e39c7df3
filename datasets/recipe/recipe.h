#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/names.h"
#include "datasets/pictures/pictures.h"
#include "datasets/recipe/distribution.h"

/// What a data set is drawn from: docs/dataset.md, docs/schemas/recipe.schema.json.
///
///   recipe     the JSON file, distributions       plan       one line a sample: scene, drawn values, seed
///   pictures   what is kept of a capture          render     lines to samples on the disk
///   state      the folder as a whole: what is there, checking, joining
namespace dualpixel::datasets {

enum class Split { train, validation, test };
inline constexpr Named<Split> kSplits[] = {{"train", Split::train, "to train with"},
                                           {"validation", Split::validation, "to choose by"},
                                           {"test", Split::test, "to judge with"}};
inline constexpr std::size_t kSplitCount = 3;

/// An entry of "scenes": one of a file, a folder of files, and a kind of drawn scene.
struct SceneSource {
  std::string file;                               ///< scene file or glTF file, absolute
  std::string folder;                             ///< of such files, absolute
  std::string kind;                               ///< of `dualpixel scene`
  std::array<std::uint64_t, 2> seeds{1, 1};       ///< first and last, of a kind
  nlohmann::json set = nlohmann::json::object();  ///< parameters of a kind
  double weight = 1;                              ///< share of the samples beside other entries'
};

/// Cameras on a shell around the scene's middle, which they look at.
struct CameraShell {
  Distribution distance;  ///< over the radius of the ball around the scene
  Distribution elevation_deg;
  Distribution azimuth_deg;
};

/// What depends on the scene as the camera sees it; resolved when a sample is rendered.
struct Relations {
  bool focus_on_surface = false;              ///< "focus": "surface": a visible one, at a random place of the picture
  std::optional<Distribution> exposure_mean;  ///< of the picture, clipped, over the white level
  std::optional<CameraShell> camera_shell;
  std::optional<Distribution> model_size_m;  ///< one for each scene: longest side of its box
  std::string environments;                  ///< folder of EXR and HDR pictures, absolute; empty: none
};

struct Recipe {
  std::string path;
  nlohmann::json json;  ///< as it was read
  int count = 0;
  std::uint64_t seed = 1;
  std::vector<SceneSource> scenes;
  std::map<std::string, Distribution> set;  ///< fields of the scene file, as `simulate --set` names them
  Relations relations;
  std::array<double, kSplitCount> shares{1, 0, 0};  ///< of the samples, in the order of kSplits; they add up to 1
  Layout layout = Layout::exr;
  std::vector<std::string>
      keep;  ///< names of pictures (datasets/pictures/pictures.h); empty where the layout has its own
};

inline constexpr int kMostSamples = 10'000'000;

/// Throws InputError: unknown fields, values out of range.
Recipe read_recipe(const std::string& path);
Recipe read_recipe(const nlohmann::json& json, const std::string& path);

/// How many splits samples are dealt out to.
std::size_t splits_with_a_share(const Recipe& recipe);

}  // namespace dualpixel::datasets
