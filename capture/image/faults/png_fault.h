#pragma once
#include <iosfwd>
#include <optional>
#include <string>

namespace dualpixel {

/// What is wrong with a PNG as a file: it ends before its last chunk, or has other bytes than it was written with (PNG
/// specification, section 5.3: chunks of a length, a name, data, and a checksum of name and data), or its header is
/// none. Asked before libpng reads, which would write lines of its own to stderr. The compressed picture itself is not
/// looked at: that would take as long as to read it.
std::optional<std::string> fault_of_png(std::istream& png);

}  // namespace dualpixel
