#include "capture/image/faults/tiff_fault.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "capture/error.h"
#include "capture/image/faults/lossless_jpeg_fault.h"
#include "capture/image/picture_limits.h"
#include "capture/image/quiet_tiff.h"

namespace dualpixel {
namespace {

constexpr std::uint64_t kMostHeaderBytes = 1 << 16;  // that are looked at of a lossless JPEG
constexpr std::uint16_t kLinearRaw = 34892;          // a photometric interpretation of DNG 1.4
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

/// The last strip of a picture may have fewer than the others.
std::uint64_t rows_of_strip(std::uint64_t strip, std::uint64_t rows, std::uint64_t height) {
  return std::min(rows, height - std::min(height, strip * rows));
}

/// What is wrong with the strips or tiles of a DNG's raw data that are lossless JPEGs.
std::optional<std::string> fault_of_jpeg_parts(TIFF* file, std::uint32_t width, std::uint32_t height,
                                               std::uint16_t channels) {
  const bool tiled = TIFFIsTiled(file) != 0;
  std::uint32_t part_width = width, part_height = height;
  if (tiled) {
    TIFFGetField(file, TIFFTAG_TILEWIDTH, &part_width);
    TIFFGetField(file, TIFFTAG_TILELENGTH, &part_height);
  } else {
    TIFFGetFieldDefaulted(file, TIFFTAG_ROWSPERSTRIP, &part_height);
  }
  const std::uint32_t parts = tiled ? TIFFNumberOfTiles(file) : TIFFNumberOfStrips(file);
  std::string part;
  for (std::uint32_t i = 0; i < parts; ++i) {
    part.resize(std::min<std::uint64_t>(TIFFGetStrileByteCount(file, i), kMostHeaderBytes));
    const auto bytes = static_cast<tmsize_t>(part.size());
    if ((tiled ? TIFFReadRawTile(file, i, part.data(), bytes) : TIFFReadRawStrip(file, i, part.data(), bytes)) != bytes)
      return "its raw data cannot be read";
    const std::uint64_t rows = tiled ? part_height : rows_of_strip(i, part_height, height);
    if (auto fault = fault_of_lossless_jpeg(part, part_width * rows * channels)) return fault;
  }
  return {};
}

/// What is wrong with a compressed picture of a DNG. Its previews are not read.
std::optional<std::string> fault_of_compressed_dng(TIFF* file, std::uint32_t width, std::uint32_t height,
                                                   std::uint16_t channels, std::uint16_t compression) {
  std::uint16_t photometric = 0;
  TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &photometric);
  if (photometric != PHOTOMETRIC_CFA && photometric != kLinearRaw) return {};
  if (compression == COMPRESSION_JPEG) return fault_of_jpeg_parts(file, width, height, channels);
  if (compression == COMPRESSION_ADOBE_DEFLATE) return {};  // LibRaw says what is wrong with it
  return fmt::format("its compression, {}, is not supported; a DNG's raw data must have none, lossless JPEG or Deflate",
                     compression);
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
  if (is_dng && compression != COMPRESSION_NONE) {
    return fault_of_compressed_dng(file, width, height, channels, compression);
  }
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
    fault = "it is no TIFF";
  } else {
    const std::uint64_t file_bytes = std::filesystem::file_size(path);
    const std::uint8_t* dng_version = nullptr;
    const bool is_dng = TIFFGetField(file.get(), TIFFTAG_DNGVERSION, &dng_version) != 0;
    fault = fault_of_directory(file.get(), file_bytes, is_dng);
    for (const std::uint64_t offset : is_dng ? directories_within(file.get()) : std::vector<std::uint64_t>()) {
      if (fault) break;
      fault = TIFFSetSubDirectory(file.get(), offset) != 0 ? fault_of_directory(file.get(), file_bytes, true)
                                                           : std::optional<std::string>("a picture of it is missing");
    }
  }
  if (fault && !error.empty()) *fault += ": " + printable(error);
  return fault;
}

}  // namespace dualpixel
