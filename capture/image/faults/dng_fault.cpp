#include "capture/image/faults/dng_fault.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace dualpixel {
namespace {

enum Marker {
  kStartOfImage = 0xffd8,
  kLosslessFrame = 0xffc3,
  kHuffmanTables = 0xffc4,
  kStartOfScan = 0xffda,
  kRestartInterval = 0xffdd
};
constexpr int kMostSegments = 100;
constexpr int kMostComponents = 4;
constexpr std::int64_t kMostTiles = 100'000;
constexpr std::int64_t kMostExcess = 4;
constexpr std::int64_t kSmallPiece = 1 << 20;  // samples; of less the last row's tiles may be mostly excess

struct Frame {
  int bits = 0, rows = 0, columns = 0, components = 0;
};

/// A frame's type is 0xffc0 to 0xffcf, without what tables and arithmetic coding have there.
bool is_frame(int marker) {
  return marker >= 0xffc0 && marker <= 0xffcf && marker != kHuffmanTables && marker != 0xffc8 && marker != 0xffcc;
}

/// Reads a JPEG's segments, one after another.
class Segments {
 public:
  explicit Segments(std::istream& file) : file_(file) {}
  int number(int bytes) {
    int value = 0;
    for (int i = 0; i < bytes; ++i) value = value << 8 | (file_.get() & 0xff);
    return file_ ? value : -1;
  }
  /// The next segment's content; none where the file ends or no segment is there.
  std::optional<std::vector<unsigned char>> next(int& marker) {
    marker = number(2);
    const int length = number(2);
    if (marker <= 0xff00 || length < 2) return {};
    std::vector<unsigned char> content(static_cast<std::size_t>(length) - 2);
    file_.read(reinterpret_cast<char*>(content.data()), static_cast<std::streamsize>(content.size()));
    if (!file_) return {};
    return content;
  }

 private:
  std::istream& file_;
};

/// The frame of a header: 3 bytes for each component, whose samples all have the same density.
std::optional<Frame> frame_of(const std::vector<unsigned char>& content) {
  if (content.size() < 6 || content.size() != 6U + 3U * content[5]) return {};
  const Frame frame{content[0], content[1] << 8 | content[2], content[3] << 8 | content[4], content[5]};
  for (int c = 0; c < frame.components; ++c) {
    if (content[7 + 3 * c] != 0x11) return {};
  }
  const bool possible = frame.bits >= 2 && frame.bits <= 16 && frame.components >= 1 &&
                        frame.components <= kMostComponents && frame.rows >= 1 && frame.columns >= 1;
  return possible ? std::optional(frame) : std::nullopt;
}

/// Whether a scan of such a frame is one that is decoded: a predictor of 1 to 7, and bits left after its point
/// transform.
bool is_scan_of(const Frame& frame, const std::vector<unsigned char>& content) {
  const std::size_t components = frame.components;
  if (content.size() != 4 + 2 * components || content[0] != components) return false;
  const int predictor = content[1 + 2 * components], shift = content[3 + 2 * components] & 0xf;
  return predictor >= 1 && predictor <= 7 && shift < frame.bits;
}

/// The frame of the JPEG that the file stands at; none where it is broken.
std::optional<Frame> read_frame(std::istream& file) {
  Segments segments(file);
  if (segments.number(2) != kStartOfImage) return {};
  std::optional<Frame> frame;
  bool has_first_table = false;
  for (int i = 0; i < kMostSegments; ++i) {
    int marker = 0;
    const auto content = segments.next(marker);
    if (!content) return {};
    if (is_frame(marker)) {
      if (frame || marker != kLosslessFrame) return {};
      frame = frame_of(*content);
      if (!frame) return {};
    }
    if (marker == kHuffmanTables) has_first_table |= !content->empty() && (*content)[0] == 0;
    if (marker == kRestartInterval && (content->size() != 2 || ((*content)[0] == 0 && (*content)[1] == 0))) return {};
    if (marker == kStartOfScan) return frame && has_first_table && is_scan_of(*frame, *content) ? frame : std::nullopt;
  }
  return {};
}

/// Whether the frame's rows, one after another, are those of a piece `width` wide, of which `rows` are needed: as many
/// samples a row, a multiple or a part. Much more would only take time.
bool fills(const Frame& frame, int width, int rows, int samples) {
  const std::int64_t row = std::int64_t{1} * frame.columns * frame.components;
  const std::int64_t needed = std::int64_t{1} * width * samples * rows;
  if (row * frame.rows < needed || row * frame.rows > kMostExcess * std::max<std::int64_t>(needed, kSmallPiece))
    return false;
  if (samples > 1) return frame.components == samples && frame.columns == width;
  return row % width == 0 || width % row == 0;
}

}  // namespace

std::optional<std::string> fault_of_lossless_dng(std::istream& file, const DngData& data) {
  const bool tiled = data.tile_width > 0 && data.tile_height > 0;
  const int width = tiled ? data.tile_width : data.width, height = tiled ? data.tile_height : data.height;
  if (width > 2 * std::int64_t{data.width} + 1024 || height > 2 * std::int64_t{data.height} + 1024) {
    return fmt::format("its raw data, {} x {}, are in tiles of {} x {}", data.width, data.height, width, height);
  }
  const std::int64_t across = (data.width + width - 1) / width, down = (data.height + height - 1) / height;
  if (across * down > kMostTiles) return fmt::format("its raw data are in {} tiles", across * down);
  int tile = 0;
  for (int top = 0; top < data.height; top += height) {
    for (int left = 0; left < data.width; left += width, ++tile) {
      file.clear();
      file.seekg(data.offset + (tiled ? 4 * tile : 0));
      if (tiled) {
        unsigned char at[4] = {};
        file.read(reinterpret_cast<char*>(at), 4);
        if (!data.big_endian) std::reverse(at, at + 4);
        file.seekg(std::int64_t{at[0]} << 24 | at[1] << 16 | at[2] << 8 | at[3]);
      }
      const auto frame = read_frame(file);
      if (!frame) return "a part of its raw data is no lossless JPEG that can be read";
      if (!fills(*frame, width, std::min(height, data.height - top), data.samples)) {
        return fmt::format("a part of its raw data has {} x {} pixels of {} samples, where {} x {} of {} are needed",
                           frame->columns, frame->rows, frame->components, width, height, data.samples);
      }
    }
  }
  return {};
}

}  // namespace dualpixel
