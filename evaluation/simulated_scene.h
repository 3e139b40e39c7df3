#pragma once
#include <string>
#include <vector>

#include "capture/capture.h"

namespace dualpixel::evaluation {

/// A capture of a scene file with some of its fields replaced, "sensor.width_px=1344" and so on, as `dualpixel simulate
/// --set` does. Throws InputError.
Capture simulate_scene(const std::string& scene_file, const std::vector<std::string>& overrides);

}  // namespace dualpixel::evaluation
