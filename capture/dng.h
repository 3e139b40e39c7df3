#pragma once
#include <string>

#include "capture/capture.h"

namespace dualpixel {

/// A raw picture as the bytes of an Adobe Digital Negative (DNG specification 1.4, 2012): little-endian, one directory,
/// 16 bits uncompressed, digital numbers as they stand. It carries black and white level, the as-shot neutral, the
/// noise profile, and as the camera's colours linear sRGB under the inverse of the white balance, which is what the
/// simulator's sensor sees. With `mosaic` it has the camera's colour filters; otherwise it is linear monochrome, as a
/// DP view is, and `noise` its own. `pixel_height` is that of a pixel over its width.
std::string dng(const ImageU16& raw, const Capture& capture, bool mosaic, const NoiseProfile& noise,
                double pixel_height = 1);

}  // namespace dualpixel
