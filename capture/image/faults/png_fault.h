#pragma once
#include <iosfwd>
#include <optional>
#include <string>

namespace dualpixel {

/// What is wrong with a PNG as a file: it ends before its last chunk, or has other bytes than it was written with (PNG
/// specification, section 5.3: chunks of a length, a name, data, and a checksum of name and data), or its header is
/// none, or its picture is broken or ends early. All of it is inflated, but of pictures of more than kMostPictureValues
/// values, which are refused anyhow. Asked before libpng reads, which would write lines of its own to stderr.
std::optional<std::string> fault_of_png(std::istream& png);

}  // namespace dualpixel
