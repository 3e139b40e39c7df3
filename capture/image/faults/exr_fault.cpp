#include "capture/image/faults/exr_fault.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <istream>

#include "capture/error.h"

namespace dualpixel {
namespace {

constexpr std::uint32_t kSeveralParts = 0x1000;
constexpr std::size_t kLongestName = 255;

std::uint32_t little_endian(std::istream& exr) {
  std::array<unsigned char, 4> bytes{};
  exr.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
  return bytes[0] | bytes[1] << 8 | bytes[2] << 16 | static_cast<std::uint32_t>(bytes[3]) << 24;
}

/// Up to a zero; the stream fails where there is none in time.
std::string name(std::istream& exr) {
  std::string text;
  for (char c = 0; exr.get(c) && c != 0;) {
    text += c;
    if (text.size() > kLongestName) exr.setstate(std::ios::failbit);
  }
  return text;
}

}  // namespace

std::optional<std::string> fault_of_exr(std::istream& exr) {
  exr.seekg(0, std::ios::end);
  const std::streamoff size = exr.tellg();
  exr.seekg(4);
  bool more = (little_endian(exr) & kSeveralParts) != 0, empty = false;
  do {
    empty = true;
    for (std::string attribute = name(exr); exr && !attribute.empty(); attribute = name(exr)) {
      empty = false;
      name(exr);  // its type
      const std::uint32_t bytes = little_endian(exr);
      if (exr && bytes > size - exr.tellg()) {
        return fmt::format("its attribute {} is said to be of {} bytes, more than the file has", printable(attribute),
                           bytes);
      }
      exr.seekg(bytes, std::ios::cur);
    }
    if (!exr) return "its header does not end";
  } while (more && !empty);  // headers of several parts end with an empty one
  return std::nullopt;
}

}  // namespace dualpixel
