#pragma once
#include <string>
#include <utility>
#include <vector>

#include "capture/image/image.h"

/// Reading and writing images through OpenImageIO, with checks: the format is recognized by its magic bytes (EXR, PNG,
/// TIFF, JPEG, HDR), a picture has at most 65536 pixels a side and 500 million values, only regular files are read.
/// PNG and TIFF are decoded once more before that, to find what their libraries would pass over (capture/image/faults).
/// All throw InputError with one line that names the file.
namespace dualpixel {

/// Any supported image as float, values as stored (integers scaled to 0..1).
Image read_image(const std::string& path);
/// 8- or 16-bit integers, unscaled; `channels` are required.
ImageU16 read_image_u16(const std::string& path, int channels);

struct PictureSize {
  std::string format;  ///< "openexr", "png", "tiff", "jpeg" or "hdr"
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< their names
};
/// What an image's header says. A PNG or TIFF whose pixels are broken is refused here, too.
PictureSize picture_size(const std::string& path);

struct NamedPlane {
  std::string channel;  ///< EXR channel name: "R", "Z", "N.X", "disparity_dp_px", ...
  const Image* image;   ///< one plane of it is written
  int image_channel = 0;
};

/// One single-part, zip-compressed EXR with the named planes, float or half; all of one size. `ids`, where given, is
/// written as the uint32 channel "id". `attributes` become header attributes.
void write_exr(const std::string& path, const std::vector<NamedPlane>& planes, bool half, const ImageU32* ids = nullptr,
               const std::vector<std::pair<std::string, float>>& attributes = {});

/// The planes of an EXR by channel name, in the order asked for. Missing channels are an error that names them.
std::vector<Image> read_exr(const std::string& path, const std::vector<std::string>& channels);
ImageU32 read_exr_ids(const std::string& path);

/// 8-bit PNG; `image` holds display-ready values 0..1: gray or RGB, and alpha that colors are not multiplied by.
/// Written with replace_file.
void write_png8(const std::string& path, const Image& image);
/// 16-bit PNG of unscaled integers, one or three channels; the header declares them linear, or sRGB.
void write_png16(const std::string& path, const ImageU16& image, bool srgb = false);

/// sRGB transfer function (IEC 61966-2-1), clamped to 0..1.
float srgb_from_linear(float linear);

/// Its inverse, for 0..1.
float linear_from_srgb(float encoded);

}  // namespace dualpixel
