#include "capture/image/faults/lossless_jpeg_fault.h"

#include <fmt/format.h>

namespace dualpixel {
namespace {

constexpr int kStartOfImage = 0xffd8, kLosslessFrame = 0xffc3, kStartOfScan = 0xffda;
constexpr std::size_t kFrameBytes = 8;  // of a frame's header up to its number of components
constexpr int kMostComponents = 4;

}  // namespace

std::optional<std::string> fault_of_lossless_jpeg(std::string_view jpeg, std::uint64_t samples) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(jpeg[at]); };
  const auto number = [&](std::size_t at) { return byte(at) << 8 | byte(at + 1); };
  if (jpeg.size() < 2 || number(0) != kStartOfImage) return "a part of its raw data is no JPEG";
  std::uint64_t found = 0;
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const int marker = number(at);
    const auto length = static_cast<std::size_t>(number(at + 2));
    if (marker <= 0xff00 || length < 2 || length > jpeg.size() - at - 2) break;
    if (marker == kLosslessFrame && length >= kFrameBytes) {
      const int bits = byte(at + 4), components = byte(at + 9);
      if (bits < 2 || bits > 16 || components < 1 || components > kMostComponents) {
        return fmt::format("a part of its raw data has {} components of {} bits", components, bits);
      }
      found = std::uint64_t{1} * number(at + 5) * number(at + 7) * components;
    }
    if (marker == kStartOfScan) {
      if (found >= samples) return {};
      return fmt::format("a part of its raw data has {} samples of {}", found, samples);
    }
    at += 2 + length;
  }
  return "a part of its raw data has no scan";
}

}  // namespace dualpixel
