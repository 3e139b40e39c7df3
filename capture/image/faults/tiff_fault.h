#pragma once
#include <optional>
#include <string>

namespace dualpixel {

/// What is wrong with a TIFF or DNG file: a part of a picture, or of a DNG's fields, that the file does not hold, that
/// no codec here can read, or that is broken. All of it is decoded, since OpenImageIO reads black there and says
/// nothing; but neither pictures of more than kMostPictureValues values, which are refused anyhow, nor the compressed
/// pictures of a DNG, which libtiff cannot (dng_fault.h).
std::optional<std::string> fault_of_tiff(const std::string& path);

}  // namespace dualpixel
