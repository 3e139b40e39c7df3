#pragma once
#include "capture/image/image.h"

namespace dualpixel {

/// Median of the 3 x 3 window around each pixel, one channel, border pixels repeated outwards; removes the solver's
/// speckles (Wadhwa et al. 2018, section 4.4).
Image median_3x3(const Image& image);

}  // namespace dualpixel
