#pragma once
#include <memory>
#include <string>

#include "simulator/render/render_scene.h"
#include "simulator/scene/scene.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// A scene that is loaded and made ready for rays once, for any number of captures of it.
struct ReadyScene {
  /// Throws as load_scene() does.
  explicit ReadyScene(const Simulation& simulation);

  Simulation loaded_for;
  std::string gltf_xxh64;  ///< of the file that was loaded
  Scene scene;
  RenderScene world;  ///< of `scene`; keeps the light that was found
};

/// Whether both load the same scene: glTF file, environment, and whether it is animated.
bool same_scene(const Simulation& a, const Simulation& b);

/// Whether a field of the scene file, named as `simulate --set` has it, is one that same_scene() goes by.
bool is_of_scene(const std::string& field);

/// Makes `ready` the scene of `simulation`, where it is not. Returns whether anything was loaded.
bool make_ready(const Simulation& simulation, std::unique_ptr<ReadyScene>& ready);

}  // namespace dualpixel::simulator
