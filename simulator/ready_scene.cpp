#include "simulator/ready_scene.h"

#include "capture/files.h"
#include "simulator/simulate.h"

namespace dualpixel::simulator {

ReadyScene::ReadyScene(const Simulation& simulation)
    : loaded_for(simulation),
      gltf_xxh64(file_hash(simulation.gltf_path)),
      scene(load_scene(simulation)),
      world(scene, simulation.light) {}

bool same_scene(const Simulation& a, const Simulation& b) {
  return a.gltf_path == b.gltf_path && a.animation == b.animation && a.unlit_white_nits == b.unlit_white_nits &&
         a.model_size_m == b.model_size_m && a.environment_model == b.environment_model &&
         a.environment_nits == b.environment_nits && a.sky == b.sky && a.environment_path == b.environment_path &&
         a.environment_nits_per_unit == b.environment_nits_per_unit;
}

bool is_of_scene(const std::string& field) {
  for (const char* name : {"gltf", "burst", "burst.animation", "unlit_white_nits", "model_size_m", "environment"}) {
    if (field == name) return true;
  }
  return field.starts_with("environment.");
}

bool make_ready(const Simulation& simulation, std::unique_ptr<ReadyScene>& ready) {
  if (ready && same_scene(ready->loaded_for, simulation)) return false;
  ready.reset();  // before the next one takes memory
  ready = std::make_unique<ReadyScene>(simulation);
  return true;
}

}  // namespace dualpixel::simulator
