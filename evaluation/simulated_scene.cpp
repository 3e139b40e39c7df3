#include "evaluation/simulated_scene.h"

#include <nlohmann/json.hpp>

#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {

Capture simulate_scene(const std::string& scene_file, const std::vector<std::string>& overrides) {
  nlohmann::json document = read_json_file(scene_file);
  simulator::apply_overrides(document, overrides);
  const simulator::Simulation s = simulator::read_simulation(document, scene_file);
  return simulator::simulate(s, simulator::load_scene(s));
}

}  // namespace dualpixel::evaluation
