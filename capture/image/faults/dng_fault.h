#pragma once
#include <cstdint>
#include <istream>
#include <optional>
#include <string>

namespace dualpixel {

/// The raw data of a DNG, as LibRaw is about to decode them.
struct DngData {
  std::int64_t offset = 0;  ///< of the data, or of a list of their tiles' offsets, four bytes each
  bool big_endian = false;  ///< that list
  int width = 0, height = 0;
  int samples = 1;                      ///< a pixel
  int tile_width = 0, tile_height = 0;  ///< 0: in one piece
};

/// What is wrong with raw data that are lossless JPEGs (ITU T.81, annexes B and H), by their headers: a piece is none,
/// is not of one sequential frame and scan, or has other samples than the picture needs. LibRaw would leave its memory
/// as it found it, or decode for hours. What the scans hold is not looked at.
std::optional<std::string> fault_of_lossless_dng(std::istream& file, const DngData& data);

}  // namespace dualpixel
