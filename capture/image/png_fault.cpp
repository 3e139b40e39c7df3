#include "capture/image/png_fault.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <istream>
#include <string_view>
#include <vector>

#include "capture/error.h"

namespace dualpixel {
namespace {

constexpr std::streamsize kSignatureBytes = 8;

std::uint32_t big_endian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::uint32_t checksum_over(std::uint32_t before, const char* bytes, std::streamsize count) {
  return static_cast<std::uint32_t>(crc32(before, reinterpret_cast<const Bytef*>(bytes), static_cast<uInt>(count)));
}

}  // namespace

std::optional<std::string> fault_of_png(std::istream& png) {
  png.ignore(kSignatureBytes);
  std::vector<char> block(1 << 16);
  std::array<char, 8> head{};
  while (png.read(head.data(), head.size())) {
    std::uint32_t checksum = checksum_over(0, &head[4], 4);
    for (std::size_t left = big_endian(head.data()); left > 0 && png;) {
      const std::size_t count = std::min(left, block.size());
      png.read(block.data(), static_cast<std::streamsize>(count));
      checksum = checksum_over(checksum, block.data(), png.gcount());
      left -= count;
    }
    std::array<char, 4> stored{};
    if (!png.read(stored.data(), stored.size())) break;
    const std::string_view name(&head[4], 4);
    if (big_endian(stored.data()) != checksum) {
      return "the checksum of its chunk " + printable(std::string(name)) + " is wrong";
    }
    if (name == "IEND") return std::nullopt;
  }
  return "the file ends before the PNG does";
}

}  // namespace dualpixel
