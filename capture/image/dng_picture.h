#pragma once
#include <iosfwd>
#include <optional>
#include <string>

#include "capture/image/image.h"

/// Digital Negatives as photographs; capture/dng.h writes them.
namespace dualpixel {

/// The orientation of a DNG, 1 to 8 as in PictureEncoding; none where a TIFF file's first directory, which has both, is
/// without the tag DNGVersion (DNG 1.4, 2012).
std::optional<int> dng_orientation(std::istream& tiff);

/// A DNG developed by LibRaw with the camera's white balance and colors: linear RGB with sRGB's primaries, 1 where it
/// clips, oriented as stored. Throws InputError for a file that is broken or has other than three colors.
Image read_dng(const std::string& path);

}  // namespace dualpixel
