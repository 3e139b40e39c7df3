#pragma once
#include "capture/image/image.h"

namespace dualpixel {

struct DisplayOptions {
  double exposure_ev = 0;  ///< stops; 0 shows the white level as white
};

/// A linear image exposed, clipped and encoded for display with the sRGB curve (IEC 61966-2-1), 0..1. Negative and
/// NaN become 0. Within 3e-5 of the curve: it is tabulated.
Image encode_for_display(const Image& linear, const DisplayOptions& options = {});

}  // namespace dualpixel
