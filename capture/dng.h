#pragma once
#include <string>

#include "capture/capture.h"

namespace dualpixel {

enum class DngImage { mosaic, view };

/// Writes a raw image as an Adobe Digital Negative (DNG specification 1.4, 2012): little-endian, one image, 16 bits
/// uncompressed, digital numbers unchanged. It carries black level, white level and noise profile of such an
/// image. A mosaic, and a view of a dense sensor, also has the camera's color filters, the as-shot neutral, and a color
/// matrix from XYZ to linear sRGB divided by the white balance, which is what the simulated sensor records. Other views
/// are linear monochrome, their pixels as high as the camera's. Throws InputError where `path` cannot be written.
void write_dng(const std::string& path, const ImageU16& raw, const Capture& capture, DngImage image);

}  // namespace dualpixel
