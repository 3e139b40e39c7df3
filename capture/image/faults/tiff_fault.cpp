#include "capture/image/faults/tiff_fault.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "capture/error.h"
#include "capture/image/picture_limits.h"
#include "capture/image/quiet_tiff.h"

namespace dualpixel {
namespace {

constexpr std::size_t kMostDirectories = 32;                                      // of a DNG, each of which is read
constexpr std::int64_t kLargestPartBytes = std::int64_t{4} * kMostPictureValues;  // what a picture takes as float

/// Of a strip or tile of the directory that the file stands at, decoded; 0 where libtiff cannot tell.
tmsize_t part_bytes(TIFF* file) { return TIFFIsTiled(file) != 0 ? TIFFTileSize(file) : TIFFStripSize(file); }

/// Decodes every strip or tile of the directory that the file stands at. An error has its text from libtiff.
bool decodes(TIFF* file) {
  const bool tiled = TIFFIsTiled(file) != 0;
  const tmsize_t bytes = part_bytes(file);
  if (bytes <= 0) return false;
  std::vector<char> part(static_cast<std::size_t>(bytes));
  const std::uint32_t parts = tiled ? TIFFNumberOfTiles(file) : TIFFNumberOfStrips(file);
  for (std::uint32_t i = 0; i < parts; ++i) {
    const tmsize_t got =
        tiled ? TIFFReadEncodedTile(file, i, part.data(), bytes) : TIFFReadEncodedStrip(file, i, part.data(), bytes);
    if (got < 0) return false;
  }
  return true;
}

/// Whether the file is long enough for what the directory says of its strips or tiles.
bool holds_its_parts(TIFF* file, std::uint64_t file_bytes) {
  const std::uint32_t parts = TIFFIsTiled(file) != 0 ? TIFFNumberOfTiles(file) : TIFFNumberOfStrips(file);
  for (std::uint32_t i = 0; i < parts; ++i) {
    const std::uint64_t begin = TIFFGetStrileOffset(file, i), bytes = TIFFGetStrileByteCount(file, i);
    if (begin > file_bytes || bytes > file_bytes - begin) return false;
  }
  return true;
}

/// Whether strips follow each other in the file, as LibRaw takes for granted.
bool is_in_one_piece(TIFF* file) {
  const std::uint32_t strips = TIFFIsTiled(file) != 0 ? 0 : TIFFNumberOfStrips(file);
  for (std::uint32_t i = 1; i < strips; ++i) {
    if (TIFFGetStrileOffset(file, i) != TIFFGetStrileOffset(file, i - 1) + TIFFGetStrileByteCount(file, i - 1))
      return false;
  }
  return true;
}

/// A number of `bytes` bytes.
std::uint32_t number(std::istream& file, int bytes, bool little) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) {
    value |= (static_cast<std::uint32_t>(file.get()) & 0xff) << 8 * (little ? i : bytes - 1 - i);
  }
  return value;
}

/// Whether the file is long enough for what the fields of the directory at `offset` point to. Of missing values libtiff
/// warns alone, and LibRaw reads zeros: colors and levels would be others.
bool holds_its_fields(const std::string& path, std::uint64_t offset, std::uint64_t file_bytes) {
  constexpr std::uint64_t kTypeBytes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4};  // of TIFF's types 1 to 13
  std::ifstream file(path, std::ios::binary);
  const bool little = number(file, 2, true) == 0x4949;
  file.seekg(static_cast<std::streamoff>(offset));
  const std::uint32_t fields = number(file, 2, little);
  for (std::uint32_t i = 0; i < fields && file; ++i) {
    number(file, 2, little);  // the tag
    const std::uint32_t type = number(file, 2, little), count = number(file, 4, little), at = number(file, 4, little);
    const std::uint64_t bytes = type < std::size(kTypeBytes) ? kTypeBytes[type] * count : 0;
    if (file && bytes > 4 && (at > file_bytes || bytes > file_bytes - at)) return false;
  }
  return static_cast<bool>(file);
}

/// Where a DNG keeps the pictures that its first directory has not.
std::vector<std::uint64_t> directories_within(TIFF* file) {
  std::uint16_t count = 0;
  const std::uint64_t* offsets = nullptr;
  if (TIFFGetField(file, TIFFTAG_SUBIFD, &count, &offsets) == 0) return {};
  return {offsets, offsets + count};
}

/// Of the directory that the file stands at.
std::optional<std::string> fault_of_directory(TIFF* file, std::uint64_t file_bytes, bool is_dng) {
  std::uint32_t width = 0, height = 0;
  std::uint16_t channels = 1, compression = COMPRESSION_NONE;
  if (TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &width) == 0 || TIFFGetField(file, TIFFTAG_IMAGELENGTH, &height) == 0) {
    return "a picture of it has no width or height";
  }
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &channels);
  TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &compression);
  if (channels == 0 || std::uint64_t{width} * height > static_cast<std::uint64_t>(kMostPictureValues) / channels)
    return {};
  if (!holds_its_parts(file, file_bytes)) return "the file ends before its picture does";
  if (is_dng && !holds_its_fields(TIFFFileName(file), TIFFCurrentDirOffset(file), file_bytes)) {
    return "the file ends before what its fields point to";
  }
  if (is_dng && compression != COMPRESSION_NONE) return {};
  if (is_dng && !is_in_one_piece(file)) return "its strips do not follow each other";
  if (TIFFIsCODECConfigured(compression) == 0) return fmt::format("its compression, {}, is not supported", compression);
  if (part_bytes(file) > kLargestPartBytes) {
    return fmt::format("a strip or tile of it takes {} bytes: at most {} are allowed", part_bytes(file),
                       kLargestPartBytes);
  }
  if (!decodes(file)) return "its picture is broken";
  return {};
}

}  // namespace

std::optional<std::string> fault_of_tiff(const std::string& path) {
  std::string error;
  const std::unique_ptr<TIFF, void (*)(TIFF*)> file(TIFFOpenExt(path.c_str(), "r", quiet_tiff(error).get()), TIFFClose);
  std::optional<std::string> fault;
  if (!file) {
    fault = "its directory of pictures is broken";
  } else {
    const std::uint64_t file_bytes = std::filesystem::file_size(path);
    const std::uint8_t* dng_version = nullptr;
    const bool is_dng = TIFFGetField(file.get(), TIFFTAG_DNGVERSION, &dng_version) != 0;
    fault = fault_of_directory(file.get(), file_bytes, is_dng);
    const std::vector<std::uint64_t> within = is_dng ? directories_within(file.get()) : std::vector<std::uint64_t>();
    if (!fault && within.size() > kMostDirectories) fault = fmt::format("it has {} pictures", within.size());
    for (const std::uint64_t offset : within) {
      if (fault) break;
      fault = TIFFSetSubDirectory(file.get(), offset) != 0 ? fault_of_directory(file.get(), file_bytes, true)
                                                           : std::optional<std::string>("a picture of it is missing");
    }
  }
  if (fault && !error.empty()) *fault += ": " + printable(error);
  return fault;
}

}  // namespace dualpixel
