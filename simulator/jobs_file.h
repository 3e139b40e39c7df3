#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// One capture of several that a jobs file asks for.
struct SimulationJob {
  std::string name;  ///< of its folder: letters, digits, '.', '_' and '-', of its own in the file
  Simulation simulation;
};

/// Puts numbers in place of what a job's document leaves to what its camera sees; gets the job's name, too.
using ResolveJob = std::function<nlohmann::json(const std::string& name, nlohmann::json document)>;

/// Reads a JSON Lines file (docs/scene.md): each line an object with `name` and, optionally, `set`, whose keys are
/// fields of the scene file ("camera.focus_distance_m") and whose values replace those of `scene`, which came from
/// `scene_path`; `resolve` is asked before it is read. All lines are checked. Throws InputError with file, line and
/// field.
std::vector<SimulationJob> read_jobs(const std::string& path, const nlohmann::json& scene,
                                     const std::string& scene_path, const ResolveJob& resolve = {});

}  // namespace dualpixel::simulator
