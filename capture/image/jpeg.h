#pragma once
#include <string>

#include "capture/image/image.h"

namespace dualpixel {

/// An sRGB picture (0..1, one or three channels) as a JPEG file's bytes; quality 0..100.
std::string jpeg(const Image& srgb, int quality);

}  // namespace dualpixel
