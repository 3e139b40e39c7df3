#include "capture/image/dng_tag.h"

#include <array>
#include <cstdint>
#include <istream>

namespace dualpixel {
namespace {

constexpr int kFieldBytes = 12;
constexpr std::uint32_t kDngVersion = 50706;

}  // namespace

bool is_dng(std::istream& tiff) {
  std::array<char, 4> bytes{};
  bool little = true;
  const auto number = [&](std::size_t count) {
    std::uint32_t value = 0;
    tiff.read(bytes.data(), static_cast<std::streamsize>(count));
    for (std::size_t i = 0; i < count; ++i) {
      value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << 8 * (little ? i : count - 1 - i);
    }
    return value;
  };
  little = number(2) == 0x4949;
  number(2);
  tiff.seekg(number(4));
  const std::uint32_t fields = number(2);
  for (std::uint32_t i = 0; i < fields && tiff; ++i) {
    if (number(2) == kDngVersion && tiff) return true;
    tiff.ignore(kFieldBytes - 2);
  }
  return false;
}

}  // namespace dualpixel
