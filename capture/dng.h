#pragma once
#include <string>

#include "capture/capture.h"

namespace dualpixel {

/// Writes a raw image as an Adobe Digital Negative (DNG specification 1.4, 2012): little-endian, one directory, 16 bits
/// uncompressed, digital numbers unchanged. It carries black and white level, the as-shot neutral, the noise profile,
/// and a color matrix from XYZ to linear sRGB divided by the white balance, which is what the simulated sensor records.
/// With `mosaic` it has the camera's color filters; otherwise it is linear monochrome, as a DP view is. `noise` is that
/// of `raw`, `pixel_height` a pixel's height over its width. Throws InputError where `path` cannot be written.
void write_dng(const std::string& path, const ImageU16& raw, const Capture& capture, bool mosaic,
               const NoiseProfile& noise, double pixel_height = 1);

}  // namespace dualpixel
