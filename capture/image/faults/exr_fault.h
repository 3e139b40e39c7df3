#pragma once
#include <iosfwd>
#include <optional>
#include <string>

namespace dualpixel {

/// What is wrong with an EXR's header: an attribute is said to be larger than the file, or the header does not end
/// (OpenEXR's document of its file layout: attributes of a name, a type, a size and a value, up to an empty name).
/// Asked before OpenEXR reads, which would take the memory first: 2 GB for a file of 572 bytes.
std::optional<std::string> fault_of_exr(std::istream& exr);

}  // namespace dualpixel
