#pragma once
#include <string>

#include "capture/image/image.h"

namespace dualpixel {

/// The first channel of an image file, as a mask. Throws InputError, with the pixel, where a value is outside [0, 1].
Image read_mask(const std::string& path);

/// A mask is stretched to its picture: throws InputError, which begins with `name`, where it has another shape. Whole
/// pixels may round: sides may miss the shape by 2 %, or by a pixel.
void require_shape(const Image& mask, int picture_width, int picture_height, const std::string& name);

}  // namespace dualpixel
