#include "capture/image/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>
#include <new>
#include <string_view>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/dng_picture.h"
#include "capture/image/faults/exr_fault.h"
#include "capture/image/faults/jpeg_fault.h"
#include "capture/image/faults/png_fault.h"
#include "capture/image/faults/tiff_fault.h"
#include "capture/image/picture_encoding.h"
#include "capture/image/picture_limits.h"

namespace dualpixel {
namespace {

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError(printable(path) + ": " + why);
}

/// OpenImageIO's name of the format that the file's first bytes tell; its name's ending says nothing.
std::string format_of(const std::string& path) {
  require_regular_file(path);
  char bytes[16] = {};
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(path, "cannot be read");
  file.read(bytes, sizeof(bytes));
  const std::string_view head(bytes, static_cast<std::size_t>(file.gcount()));
  using namespace std::string_view_literals;
  if (head.starts_with("\x76\x2f\x31\x01"sv)) return "openexr";
  if (head.starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
  if (head.starts_with("II*\0"sv) || head.starts_with("MM\0*"sv) || head.starts_with("II+\0"sv)) return "tiff";
  if (head.starts_with("\xff\xd8\xff"sv)) return "jpeg";
  if (head.starts_with("#?RADIANCE"sv) || head.starts_with("#?RGBE"sv)) return "hdr";
  refuse(path, "is not a picture that can be read (EXR, PNG, TIFF, JPEG or HDR)");
}

std::string one_line(const std::string& library_message) {
  return library_message.empty() ? "unknown error" : printable(library_message.substr(0, library_message.find('\n')));
}

std::unique_ptr<ImageInput> open_picture(const std::string& path) {
  const std::string format = format_of(path);
  std::unique_ptr<ImageInput> input = ImageInput::create(format);
  if (!input) refuse(path, "this build of OpenImageIO cannot read " + format);
  using FaultOf = std::optional<std::string>(std::istream&);
  FaultOf* const fault_of = format == "png"       ? fault_of_png
                            : format == "jpeg"    ? fault_of_jpeg
                            : format == "openexr" ? fault_of_exr
                                                  : nullptr;
  if (fault_of) {
    std::ifstream file(path, std::ios::binary);
    if (const auto fault = fault_of(file)) refuse(path, "cannot be read: " + *fault);
  }
  if (format == "tiff") {
    if (const auto fault = fault_of_tiff(path)) refuse(path, "cannot be read: " + *fault);
  }
  ImageSpec as_stored, spec;
  as_stored["oiio:UnassociatedAlpha"] = 1;
  if (!input->open(path, spec, as_stored)) refuse(path, "cannot be read: " + one_line(input->geterror()));
  if (spec.deep) refuse(path, "deep EXR is not supported");
  require_allowed_size(path, spec.width, spec.height, spec.nchannels);
  if (spec.depth > 1) refuse(path, "volumes are not supported");
  if (spec.tile_width > 0) require_allowed_size(path, spec.tile_width, spec.tile_height, spec.nchannels);
  if (format == "openexr") {
    if (input->seek_subimage(1, 0)) refuse(path, "EXR of several parts is not supported");
    input->geterror();  // the message that there is no second part
    if (!input->seek_subimage(0, 0)) refuse(path, "cannot be read: " + one_line(input->geterror()));
  }
  return input;
}

/// Runs `read`, and turns whatever the library throws over a broken file into one line.
template <typename Read>
auto reading(const std::string& path, Read read) {
  try {
    return read();
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    refuse(path, "there is not enough memory for the picture");
  } catch (const std::exception& error) {
    refuse(path, "cannot be read: " + one_line(error.what()));
  }
}

/// Channels [begin, end) as T, interleaved.
template <typename T>
ImageOf<T> read_channels(ImageInput& input, const std::string& path, int begin, int end, TypeDesc type) {
  const ImageSpec& spec = input.spec();
  ImageOf<T> image(spec.width, spec.height, end - begin);
  if (!input.read_image(0, 0, begin, end, type, image.data.data())) {
    refuse(path, "cannot be read: " + one_line(input.geterror()));
  }
  return image;
}

int find_channel(const ImageSpec& spec, const std::string& path, const std::string& channel) {
  const auto found = std::find(spec.channelnames.begin(), spec.channelnames.end(), channel);
  if (found == spec.channelnames.end()) {
    refuse(path, fmt::format("has no channel '{}' (it has {})", printable(channel),
                             printable(fmt::format("{}", fmt::join(spec.channelnames, ", ")))));
  }
  return static_cast<int>(found - spec.channelnames.begin());
}

/// Encodes `pixels` (their type is the spec's own where `type` is UNKNOWN) in memory, then writes the file: the library
/// would not notice a disk that is full.
void write_picture(const std::string& path, const std::string& format, const ImageSpec& spec, TypeDesc type,
                   const void* pixels, void (*write)(const std::string&, std::string_view) = write_file) {
  const std::unique_ptr<ImageOutput> output = ImageOutput::create(format);
  if (!output) refuse(path, "this build of OpenImageIO cannot write " + format);
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  if (!output->set_ioproxy(&memory) || !output->open(path, spec) || !output->write_image(type, pixels) ||
      !output->close()) {
    refuse(path, "cannot be written: " + one_line(output->geterror()));
  }
  write(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace

Image read_image(const std::string& path) {
  return reading(path, [&] {
    const std::unique_ptr<ImageInput> input = open_picture(path);
    return read_channels<float>(*input, path, 0, input->spec().nchannels, TypeDesc::FLOAT);
  });
}

ImageU16 read_image_u16(const std::string& path, int channels) {
  return reading(path, [&] {
    const std::unique_ptr<ImageInput> input = open_picture(path);
    const ImageSpec& spec = input->spec();
    if (spec.nchannels != channels) {
      refuse(path, fmt::format("has {} channels; {} are needed", spec.nchannels, channels));
    }
    if (spec.format == TypeDesc::UINT16) return read_channels<std::uint16_t>(*input, path, 0, channels, spec.format);
    if (spec.format != TypeDesc::UINT8) {
      refuse(path, fmt::format("holds {}; integers of 8 or 16 bits are needed", spec.format.c_str()));
    }
    const ImageOf<std::uint8_t> bytes = read_channels<std::uint8_t>(*input, path, 0, channels, spec.format);
    ImageU16 image(bytes.width, bytes.height, channels);
    std::copy(bytes.data.begin(), bytes.data.end(), image.data.begin());
    return image;
  });
}

void write_exr(const std::string& path, const std::vector<NamedPlane>& planes, bool half, const ImageU32* ids,
               const std::vector<std::pair<std::string, float>>& attributes) {
  const int width = ids ? ids->width : planes.front().image->width;
  const int height = ids ? ids->height : planes.front().image->height;
  const TypeDesc plane_type = half ? TypeDesc::HALF : TypeDesc::FLOAT;

  ImageSpec spec(width, height, static_cast<int>(planes.size()) + (ids ? 1 : 0), plane_type);
  spec.channelnames.clear();
  for (const NamedPlane& plane : planes) {
    if (plane.image->width != width || plane.image->height != height) {
      throw std::invalid_argument(path + ": planes of one EXR must be of one size");
    }
    spec.channelnames.push_back(plane.channel);
    spec.channelformats.push_back(plane_type);
  }
  if (ids) {
    spec.channelnames.push_back("id");
    spec.channelformats.push_back(TypeDesc::UINT32);
  }
  spec["compression"] = "zip:2";  // a little larger than by the default level 4, and faster
  for (const auto& [name, value] : attributes) spec.attribute(name, value);
  // OpenImageIO would put in the current time: the same picture must be the same bytes.
  spec.attribute("DateTime", "1970:01:01 00:00:00");

  // Interleave: each channel in its own type.
  const std::size_t pixel_bytes = spec.pixel_bytes(true);
  std::vector<char> pixels(pixel_bytes * width * height);
  std::size_t offset = 0;
  const auto put = [&](const void* source, TypeDesc source_type, int source_channels, TypeDesc type) {
    OIIO::parallel_convert_image(1, width, height, 1, source, source_type,
                                 static_cast<OIIO::stride_t>(source_channels * source_type.size()), OIIO::AutoStride,
                                 OIIO::AutoStride, pixels.data() + offset, type,
                                 static_cast<OIIO::stride_t>(pixel_bytes), OIIO::AutoStride, OIIO::AutoStride);
    offset += type.size();
  };
  for (const NamedPlane& plane : planes) {
    put(plane.image->data.data() + plane.image_channel, TypeDesc::FLOAT, plane.image->channels, plane_type);
  }
  if (ids) put(ids->data.data(), TypeDesc::UINT32, 1, TypeDesc::UINT32);
  write_picture(path, "openexr", spec, ids ? TypeDesc(TypeDesc::UNKNOWN) : plane_type, pixels.data());
}

std::vector<Image> read_exr(const std::string& path, const std::vector<std::string>& channels) {
  return reading(path, [&] {
    const std::unique_ptr<ImageInput> input = open_picture(path);
    std::vector<int> stored;
    for (const std::string& channel : channels) stored.push_back(find_channel(input->spec(), path, channel));
    // One pass over the file, from the first channel to the last that is asked for.
    const auto [first, last] = std::minmax_element(stored.begin(), stored.end());
    const Image all = read_channels<float>(*input, path, *first, *last + 1, TypeDesc::FLOAT);
    std::vector<Image> planes;
    for (const int channel : stored) {
      Image& plane = planes.emplace_back(all.width, all.height);
      for (std::size_t i = 0; i < plane.data.size(); ++i) plane.data[i] = all.data[i * all.channels + channel - *first];
    }
    return planes;
  });
}

PictureSize picture_size(const std::string& path) {
  return reading(path, [&]() -> PictureSize {
    const std::unique_ptr<ImageInput> input = open_picture(path);
    const ImageSpec& spec = input->spec();
    return {input->format_name(), spec.width, spec.height, spec.channelnames};
  });
}

PictureEncoding picture_encoding(const std::string& path) {
  return reading(path, [&] {
    PictureEncoding encoding;
    if (format_of(path) == "tiff") {
      std::ifstream file(path, std::ios::binary);
      if (const auto orientation = dng_orientation(file)) {
        encoding.orientation = *orientation;
        encoding.dng = true;
        return encoding;
      }
    }
    const std::unique_ptr<ImageInput> input = open_picture(path);
    const ImageSpec& spec = input->spec();
    const int orientation = spec.get_int_attribute("Orientation", 1);
    if (orientation >= 1 && orientation <= 8) encoding.orientation = orientation;
    const std::string space = spec.get_string_attribute("oiio:ColorSpace").substr(0, 3);
    encoding.linear = space == "Lin" || space == "lin";
    encoding.profile = spec.find_attribute("ICCProfile") != nullptr;
    return encoding;
  });
}

ImageU32 read_exr_ids(const std::string& path) {
  return reading(path, [&] {
    const std::unique_ptr<ImageInput> input = open_picture(path);
    const int channel = find_channel(input->spec(), path, "id");
    if (input->spec().channelformat(channel) != TypeDesc::UINT32) refuse(path, "channel 'id' must be uint32");
    return read_channels<std::uint32_t>(*input, path, channel, channel + 1, TypeDesc::UINT32);
  });
}

void write_png8(const std::string& path, const Image& image) {
  ImageSpec spec(image.width, image.height, image.channels, TypeDesc::UINT8);
  spec["oiio:ColorSpace"] = "sRGB";
  spec["oiio:UnassociatedAlpha"] = 1;  // as read_image() takes it
  write_picture(path, "png", spec, TypeDesc::FLOAT, image.data.data(), replace_file);
}

void write_png16(const std::string& path, const ImageU16& image, bool srgb) {
  ImageSpec spec(image.width, image.height, image.channels, TypeDesc::UINT16);
  spec["oiio:ColorSpace"] = srgb ? "sRGB" : "Linear";
  spec["png:compressionLevel"] = 1;  // sensor noise does not compress further, it only takes longer
  write_picture(path, "png", spec, TypeDesc::UINT16, image.data.data());
}

float srgb_from_linear(float linear) {
  const float clamped = linear > 0 ? std::min(linear, 1.0f) : 0;  // NaN becomes 0
  return clamped <= 0.0031308f ? 12.92f * clamped : 1.055f * std::pow(clamped, 1 / 2.4f) - 0.055f;
}

float linear_from_srgb(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

}  // namespace dualpixel
