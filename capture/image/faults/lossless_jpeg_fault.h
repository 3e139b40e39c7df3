#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace dualpixel {

/// What is wrong with the headers of a lossless JPEG (ITU T.81, annexes B and H), as a DNG's raw data are compressed:
/// it begins otherwise, has no scan, or a frame of less than `samples` samples. LibRaw would leave memory as it finds
/// it. Its compressed data are not looked at.
std::optional<std::string> fault_of_lossless_jpeg(std::string_view jpeg, std::uint64_t samples);

}  // namespace dualpixel
