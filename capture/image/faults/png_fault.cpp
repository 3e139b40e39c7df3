#include "capture/image/faults/png_fault.h"

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

/// Section 11.2.2: width, height, bit depth, color type, compression, filter, interlacing.
bool is_header(std::string_view chunk) {
  if (chunk.size() != 13) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(chunk[i]); };
  const unsigned depth = byte(8);
  const std::string_view depths = byte(9) == 0                                   ? "\1\2\4\10\20"
                                  : byte(9) == 3                                 ? "\1\2\4\10"
                                  : byte(9) == 2 || byte(9) == 4 || byte(9) == 6 ? "\10\20"
                                                                                 : "";
  constexpr std::uint32_t kLongestSide = 1000000;  // that libpng reads
  const auto is_side = [&](std::size_t i) { return big_endian(&chunk[i]) - 1 < kLongestSide; };
  return is_side(0) && is_side(4) && depths.find(static_cast<char>(depth)) != std::string_view::npos && byte(10) == 0 &&
         byte(11) == 0 && byte(12) <= 1;
}

/// The first bytes of the picture's zlib stream: deflate, a window of up to 32 kB, no dictionary (RFC 1950).
bool begins_zlib(std::string_view chunk) {
  if (chunk.size() < 2) return true;  // what is missing comes in the next
  const unsigned method = static_cast<unsigned char>(chunk[0]), flags = static_cast<unsigned char>(chunk[1]);
  return method % 16 == 8 && method / 16 <= 7 && (256 * method + flags) % 31 == 0 && (flags & 0x20) == 0;
}

}  // namespace

std::optional<std::string> fault_of_png(std::istream& png) {
  png.ignore(kSignatureBytes);
  std::vector<char> block(1 << 16);
  std::array<char, 8> head{};
  bool first = true, data_seen = false;
  while (png.read(head.data(), head.size())) {
    const std::string name(&head[4], 4);
    std::uint32_t checksum = checksum_over(0, &head[4], 4);
    std::string beginning;
    for (std::size_t left = big_endian(head.data()); left > 0 && png;) {
      const std::size_t count = std::min(left, block.size());
      png.read(block.data(), static_cast<std::streamsize>(count));
      checksum = checksum_over(checksum, block.data(), png.gcount());
      if (beginning.empty()) beginning.assign(block.data(), std::min<std::size_t>(png.gcount(), 64));
      left -= count;
    }
    std::array<char, 4> stored{};
    if (!png.read(stored.data(), stored.size())) break;
    if (big_endian(stored.data()) != checksum) {
      return "the checksum of its chunk " + printable(name) + " is wrong";
    }
    if ((name == "IHDR") != first) return "IHDR must be its first chunk, and the only one of that name";
    if (first && !is_header(beginning))
      return "its header IHDR says what no PNG may, or that it is of more than a million pixels a side";
    first = false;
    const bool critical = name[0] >= 'A' && name[0] <= 'Z';
    if (critical && name != "IHDR" && name != "PLTE" && name != "IDAT" && name != "IEND") {
      return "its critical chunk " + printable(name) + " is of no kind that is known";
    }
    if (name == "IDAT" && !data_seen && !begins_zlib(beginning)) return "its chunk IDAT holds no compressed data";
    data_seen = data_seen || name == "IDAT";
    if (name == "IEND") return data_seen ? std::nullopt : std::optional<std::string>("it has no chunk IDAT");
  }
  return "the file ends before the PNG does";
}

}  // namespace dualpixel
