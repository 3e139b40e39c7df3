#pragma once
#include <iosfwd>
#include <optional>
#include <string>

namespace dualpixel {

/// What is wrong with a JPEG as a file: it ends before its end marker (ITU T.81, annex B). libjpeg would go on in gray.
/// What lies behind the end, as phones put films there, is not looked at.
std::optional<std::string> fault_of_jpeg(std::istream& jpeg);

}  // namespace dualpixel
