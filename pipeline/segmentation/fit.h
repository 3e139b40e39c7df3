#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// A linear picture scaled, keeping its shape, to `longer_side_px` on its longer side (the other is at least 1 px), as
/// means over areas where it shrinks. A single channel becomes three; values are clipped to 0..1, as a camera would,
/// before they mix, and NaN becomes 0.
Image fitted(const Image& linear, int longer_side_px);

}  // namespace dualpixel::pipeline
