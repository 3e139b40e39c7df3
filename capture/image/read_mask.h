#pragma once
#include <string>

#include "capture/image/image.h"

namespace dualpixel {

/// The first channel of an image file, as a mask. Throws InputError, with the pixel, where a value is outside [0, 1].
Image read_mask(const std::string& path);

}  // namespace dualpixel
