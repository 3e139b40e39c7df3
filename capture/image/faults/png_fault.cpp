#include "capture/image/faults/png_fault.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <istream>
#include <string_view>
#include <vector>

#include "capture/error.h"
#include "capture/image/picture_limits.h"

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

/// The scanlines that a header asks for, in the order of the file: sections 7.2 and 8.2, of one pass or of the seven of
/// interlacing. A scanline is a filter type, 0 to 4, and its pixels.
struct Pass {
  std::uint64_t scanline_bytes = 0, scanlines = 0;
};

std::vector<Pass> passes_of(std::string_view header) {
  constexpr int kInterlaced[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                     {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};  // first x and y, steps
  constexpr int kWhole[4] = {0, 0, 1, 1};
  const std::uint64_t width = big_endian(&header[0]), height = big_endian(&header[4]);
  const int color = static_cast<unsigned char>(header[9]), channels = color == 2   ? 3
                                                                      : color == 4 ? 2
                                                                      : color == 6 ? 4
                                                                                   : 1;
  std::vector<Pass> passes;
  const auto add = [&](const int(&pass)[4]) {
    const std::uint64_t columns = (width + pass[2] - 1 - pass[0]) / pass[2];
    const std::uint64_t rows = (height + pass[3] - 1 - pass[1]) / pass[3];
    const std::uint64_t bits = std::uint64_t{static_cast<unsigned char>(header[8])} * channels;
    if (columns > 0 && rows > 0) passes.push_back({1 + (columns * bits + 7) / 8, rows});
  };
  if (width * height * channels > std::uint64_t{kMostPictureValues}) return passes;  // refused by who asks for it
  if (header[12] == 0) {
    add(kWhole);
  } else {
    for (const auto& pass : kInterlaced) add(pass);
  }
  return passes;
}

/// Inflates the picture, and looks whether all of it is there.
class Inflating {
 public:
  explicit Inflating(std::string_view header) : passes_(passes_of(header)) { inflateInit(&stream_); }
  ~Inflating() { inflateEnd(&stream_); }
  Inflating(const Inflating&) = delete;
  Inflating& operator=(const Inflating&) = delete;

  /// What is wrong with the next bytes of the stream.
  std::optional<std::string> take(char* bytes, std::size_t count) {
    stream_.next_in = reinterpret_cast<Bytef*>(bytes);
    stream_.avail_in = static_cast<uInt>(count);
    while (!passes_.empty() && !ended_) {
      stream_.next_out = block_.data();
      stream_.avail_out = static_cast<uInt>(block_.size());
      const int status = inflate(&stream_, Z_NO_FLUSH);
      ended_ = status == Z_STREAM_END || complete();  // what follows the picture is nobody's
      if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR) {
        return std::string("its compressed picture is broken: ") + (stream_.msg ? stream_.msg : "no memory");
      }
      const std::size_t inflated = block_.size() - stream_.avail_out;
      if (!count_scanlines(inflated)) return "a scanline of it has a filter type that no PNG may have";
      if (inflated == 0) break;
    }
    return {};
  }
  bool complete() const { return pass_ == passes_.size(); }

 private:
  bool count_scanlines(std::size_t inflated) {
    for (std::size_t at = 0; at < inflated && pass_ < passes_.size();) {
      const Pass& pass = passes_[pass_];
      if (in_scanline_ == 0 && block_[at] > 4) return false;
      const std::size_t step = std::min<std::uint64_t>(pass.scanline_bytes - in_scanline_, inflated - at);
      at += step;
      in_scanline_ = (in_scanline_ + step) % pass.scanline_bytes;
      if (in_scanline_ == 0 && ++scanline_ == pass.scanlines) ++pass_, scanline_ = 0;
    }
    return true;
  }

  std::vector<Pass> passes_;
  z_stream stream_{};
  std::vector<Bytef> block_ = std::vector<Bytef>(1 << 16);
  std::size_t pass_ = 0;
  std::uint64_t scanline_ = 0, in_scanline_ = 0;
  bool ended_ = false;
};

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
  std::optional<Inflating> picture;  ///< once the header is known
  bool data_seen = false, needs_palette = false;
  while (png.read(head.data(), head.size())) {
    const std::string name(&head[4], 4);
    std::uint32_t checksum = checksum_over(0, &head[4], 4);
    std::string beginning;
    std::optional<std::string> broken;
    for (std::size_t left = big_endian(head.data()); left > 0 && png;) {
      const std::size_t count = std::min(left, block.size());
      png.read(block.data(), static_cast<std::streamsize>(count));
      checksum = checksum_over(checksum, block.data(), png.gcount());
      if (name == "IDAT" && picture && !broken) broken = picture->take(block.data(), png.gcount());
      if (beginning.empty()) beginning.assign(block.data(), std::min<std::size_t>(png.gcount(), 64));
      left -= count;
    }
    std::array<char, 4> stored{};
    if (!png.read(stored.data(), stored.size())) break;
    if (big_endian(stored.data()) != checksum) {
      return "the checksum of its chunk " + printable(name) + " is wrong";
    }
    if ((name == "IHDR") == picture.has_value()) return "IHDR must be its first chunk, and the only one of that name";
    if (name == "IHDR") {
      if (!is_header(beginning))
        return "its header IHDR says what no PNG may, or that it is of more than a million pixels a side";
      picture.emplace(beginning);
      needs_palette = beginning[9] == 3;
    }
    if (name == "PLTE") needs_palette = false;
    const bool critical = name[0] >= 'A' && name[0] <= 'Z';
    if (critical && name != "IHDR" && name != "PLTE" && name != "IDAT" && name != "IEND") {
      return "its critical chunk " + printable(name) + " is of no kind that is known";
    }
    if (name == "IDAT" && !data_seen && !begins_zlib(beginning)) return "its chunk IDAT holds no compressed data";
    if (name == "IDAT" && needs_palette) return "it has no palette PLTE before its picture";
    if (broken) return broken;
    data_seen = data_seen || name == "IDAT";
    if (name != "IEND") continue;
    if (!data_seen) return "it has no chunk IDAT";
    return picture->complete() ? std::nullopt : std::optional<std::string>("its picture ends early");
  }
  return "the file ends before the PNG does";
}

}  // namespace dualpixel
