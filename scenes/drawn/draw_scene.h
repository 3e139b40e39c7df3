#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scenes/drawn/parameters.h"
#include "scenes/drawn/scene_builder.h"
#include "simulator/scene/environment.h"

/// Scenes from a seed.
///
///   gltf        meshes, pictures, .glb files
///   shapes      solids, plants, people as meshes      textures   pictures by code
///   drawn       parameters, builder, exposure         kinds      what is in a scene: one file each
namespace dualpixel::scenes {

/// Values of a choice with each of which a kind draws one model, whatever the seed.
struct FixedModels {
  const char* parameter = nullptr;
  std::vector<std::string> values;
};

struct SceneKind {
  const char* name;
  const char* description;
  std::vector<Parameter> parameters;  ///< besides those of all kinds
  void (*build)(SceneBuilder& builder, const Parameters& parameters, RandomStream rng);
  /// The `environment` that build() makes, its model alone: known before anything is drawn.
  simulator::EnvironmentModel (*environment)(const Parameters& parameters);
  FixedModels fixed_models = {};
};

struct SceneOrder {
  std::string kind;
  std::uint64_t seed = 1;
  /// "objects=12": a parameter. "lens.f_number=4", with a dot: a field of the scene file.
  std::vector<std::string> assignments;
};

inline constexpr int kArrangements = 4;

/// Parameters of all kinds and then the kind's own.
std::vector<Parameter> parameters_of(const SceneKind& kind);

/// The value, one of kind.fixed_models, by which the order draws the same model as for any seed; empty: the model is
/// the seed's own. Throws InputError.
std::string fixed_model_of(const SceneKind& kind, const SceneOrder& order);

/// Writes scene.json and scene.glb into a folder that exists; the same bytes for the same order and any number of
/// threads. Where the camera does not stand in free space, shows nothing or finds no exposure, everything that is not
/// set is arranged anew, kArrangements times in all; returns what is wrong with the last of them, one line each. Throws
/// InputError.
std::vector<std::string> draw_scene(const SceneKind& kind, const SceneOrder& order, const std::string& folder);

/// What draw_scene() writes into scene.json before anything is drawn: sensor, lens, burst, render and the environment's
/// model, with those of the order's fields. Throws InputError where a parameter cannot be used.
nlohmann::json scene_file_start(const SceneKind& kind, const SceneOrder& order);

/// A definition: {"kind": "still_life", "seed": 3, "set": {"objects": 12, "lens.f_number": 2.4}}, with a "title" that
/// says what it tests. Throws InputError.
SceneOrder read_scene_order(const std::string& path);

/// The assignments that an object of names and values stands for.
std::vector<std::string> assignments_of(const nlohmann::json& set);

}  // namespace dualpixel::scenes
