#include "capture/image/dng_picture.h"

#include <fmt/format.h>
#include <libraw/libraw.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fstream>
#include <istream>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string_view>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/faults/dng_fault.h"
#include "capture/image/faults/tiff_fault.h"
#include "capture/image/picture_limits.h"

namespace dualpixel {
namespace {

constexpr std::uint32_t kOrientation = 274, kDngVersion = 50706;
constexpr std::uint32_t kShort = 3;     // a field's type: 16 bits
constexpr unsigned kFloatingPoint = 3;  // TIFF's SampleFormat

/// Set to give what OpenImageIO's raw reader gives. It is not used, as LibRaw then prints a line about broken data, and
/// the reader takes them as they are.
std::unique_ptr<LibRaw> make_developer() {
  static std::mutex mutex;  // LibRaw's constructor is not safe for threads (OpenImageIO's issue 2630)
  const std::lock_guard lock(mutex);
  auto raw = std::make_unique<LibRaw>();
  raw->set_dataerror_handler(nullptr, nullptr);  // prints nothing: error_count() tells
#if LIBRAW_VERSION < LIBRAW_MAKE_VERSION(0, 21, 0)
  raw->set_memerror_handler(nullptr, nullptr);
#endif
  libraw_output_params_t& wanted = raw->imgdata.params;
  wanted.output_bps = 16;
  wanted.output_color = 1;  // sRGB's primaries
  wanted.gamm[0] = wanted.gamm[1] = 1;
  wanted.use_camera_wb = 1;
  wanted.no_auto_bright = 1;
  wanted.adjust_maximum_thr = 0;  // white is where the file says
  wanted.user_flip = 0;           // LibRaw takes any number for an orientation
  wanted.user_qual = 3;           // adaptive homogeneity-directed demosaicking
  return raw;
}

/// Throws for a status of LibRaw's, or one of the system's, that is not success.
void require(int status, const std::string& path) {
  if (status == LIBRAW_UNSUFFICIENT_MEMORY || status == ENOMEM) throw std::bad_alloc();
  if (status != LIBRAW_SUCCESS) throw InputError(printable(path) + ": cannot be read: " + libraw_strerror(status));
}

/// Of the data that an opened file is about to give. What LibRaw reads without a word about faults is refused.
std::optional<std::string> fault_of_raw_data(LibRaw& raw, const std::string& path) {
  const unpacker_data_t& unpacker = raw.get_internal_data_pointer()->unpacker_data;
  const libraw_image_sizes_t& sizes = raw.imgdata.sizes;
  DngData data{unpacker.data_offset, unpacker.order == 0x4d4d, sizes.raw_width, sizes.raw_height};
  if (raw.imgdata.idata.filters == 0) data.samples = static_cast<int>(unpacker.tiff_samples);
  if (unpacker.tile_length < INT_MAX) {
    data.tile_width = static_cast<int>(std::min<unsigned>(unpacker.tile_width, INT_MAX));
    data.tile_height = static_cast<int>(unpacker.tile_length);
  }
  require_allowed_size(path, data.width, data.height, data.samples);
  libraw_decoder_info_t decoder{};
  raw.get_decoder_info(&decoder);
  const std::string_view name = decoder.decoder_name != nullptr ? decoder.decoder_name : "";
  if (name == "lossless_dng_load_raw()") {
    std::ifstream file(path, std::ios::binary);
    return fault_of_lossless_dng(file, data);
  }
  if (name != "packed_dng_load_raw()") {
    return fmt::format("its compression, {}, is not supported; raw data must have none or be lossless JPEG",
                       unpacker.tiff_compress);
  }
  if (data.tile_height > 0) return "its raw data are tiles without compression, which is not supported";
  if (unpacker.tiff_bps > 16 || unpacker.tiff_sampleformat == kFloatingPoint) {
    return fmt::format("its raw data have {} bits{}; at most 16, without a point, are supported", unpacker.tiff_bps,
                       unpacker.tiff_sampleformat == kFloatingPoint ? " with a point" : "");
  }
  return {};
}

Image develop(LibRaw& raw, const std::string& path) {
  require(raw.open_file(path.c_str()), path);
  const libraw_image_sizes_t& sizes = raw.imgdata.sizes;
  const int colors = raw.imgdata.idata.colors;
  require_allowed_size(path, sizes.width, sizes.height, colors);
  // Pixels that are not square are made so; LibRaw keeps sides in 16 bits, and would wrap.
  const double aspect = sizes.pixel_aspect;
  require_allowed_size(path, std::llround(sizes.width * std::max(aspect, 1.0)),
                       std::llround(sizes.height / std::min(aspect, 1.0)), colors);
  if (colors != 3) {
    throw InputError(fmt::format("{}: has {} channels; a DNG in color is needed", printable(path), colors));
  }
  if (const auto fault = fault_of_raw_data(raw, path)) {
    throw InputError(printable(path) + ": cannot be read: " + *fault);
  }
  require(raw.unpack(), path);
  const libraw_colordata_t& levels = raw.imgdata.color;
  if (levels.maximum <= levels.black) {
    throw InputError(fmt::format("{}: cannot be read: its white level, {}, is not above its black level, {}",
                                 printable(path), levels.maximum, levels.black));
  }
  if (raw.error_count() > 0) throw InputError(printable(path) + ": cannot be read: its raw data are broken");
  require(raw.dcraw_process(), path);
  int status = LIBRAW_SUCCESS;
  const std::unique_ptr<libraw_processed_image_t, void (*)(libraw_processed_image_t*)> developed(
      raw.dcraw_make_mem_image(&status), LibRaw::dcraw_clear_mem);
  require(status, path);
  // dcraw_process() may fail for want of memory without saying so.
  if (!developed || developed->colors != 3 || developed->bits != 16 || developed->width == 0) throw std::bad_alloc();
  Image rgb(developed->width, developed->height, 3);
  const auto* values = reinterpret_cast<const std::uint16_t*>(developed->data);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = static_cast<float>(values[i]) / 65535;
  return rgb;
}

}  // namespace

std::optional<int> dng_orientation(std::istream& tiff) {
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
  bool has_version = false;
  int orientation = 1;
  for (std::uint32_t i = 0; i < fields && tiff; ++i) {
    const std::uint32_t tag = number(2), type = number(2);
    tiff.ignore(4);  // how many values
    const std::uint32_t value = number(2);
    tiff.ignore(2);
    has_version |= tag == kDngVersion && tiff;
    if (tag == kOrientation && type == kShort && value >= 1 && value <= 8) orientation = static_cast<int>(value);
  }
  return has_version ? std::optional(orientation) : std::nullopt;
}

Image read_dng(const std::string& path) {
  require_regular_file(path);
  if (const auto fault = fault_of_tiff(path)) throw InputError(printable(path) + ": cannot be read: " + *fault);
  try {
    return develop(*make_developer(), path);
  } catch (const std::bad_alloc&) {
    throw InputError(printable(path) + ": there is not enough memory for the picture");
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(printable(path) + ": cannot be read: " + printable(error.what()));
  }
}

}  // namespace dualpixel
