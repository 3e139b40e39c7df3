#pragma once
#include <functional>
#include <string>
#include <vector>

#include "pipeline/calibration/calibration.h"

namespace dualpixel::evaluation {

struct CaptureMeasurements {
  Camera camera;  ///< the first capture's; all have the same
  std::vector<pipeline::TargetMeasurement> measurements;
};

/// Measures captures of a flat, textured target. `folder` holds them and distances.json: {"captures": [{"capture":
/// FOLDER, "target_distance_m": NUMBER}, ...]}. Throws InputError, also where the views of a capture match on less than
/// half of the picture.
CaptureMeasurements measure_captures(const std::string& folder, const std::function<void(double fraction)>& progress);

}  // namespace dualpixel::evaluation
