#pragma once
#include <iosfwd>
#include <string>

#include "capture/image/image.h"

/// Digital Negatives as photographs; capture/dng.h writes them.
namespace dualpixel {

/// Whether a TIFF file's first directory says that it is a DNG: it has the tag DNGVersion (DNG 1.4, 2012).
bool is_dng(std::istream& tiff);

/// A DNG developed by LibRaw with the camera's white balance and colors: linear RGB with sRGB's primaries, 1 where it
/// clips, upright. Throws InputError for a file that is broken or has other than three colors.
Image read_dng(const std::string& path);

}  // namespace dualpixel
