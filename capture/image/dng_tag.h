#pragma once
#include <iosfwd>

namespace dualpixel {

/// Whether a TIFF file's first directory says that it is a DNG: it has the tag DNGVersion (DNG 1.4, 2012).
bool is_dng(std::istream& tiff);

}  // namespace dualpixel
