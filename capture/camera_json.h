#pragma once
#include "capture/capture.h"
#include "capture/json_fields.h"

namespace dualpixel {

/// What captures and calibrations both say of a camera, each within the range that a capture may have: name, size,
/// pixel pitch, DP pixel, focal length, f-number and principal point (absent: the middle of the picture).
void read_intrinsics(Fields& fields, Camera& camera);

}  // namespace dualpixel
