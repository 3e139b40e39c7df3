#pragma once
#include "capture/capture.h"
#include "capture/json_fields.h"

namespace dualpixel {

/// The camera fields that captures and calibrations share, with the ranges of a capture: name, size,
/// pixel pitch, DP pixel, focal length, f-number and principal point (absent: the middle of the picture).
void read_intrinsics(Fields& fields, Camera& camera);

}  // namespace dualpixel
