#include "capture/dng.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/quiet_tiff.h"

namespace dualpixel {
namespace {

/// From CIE XYZ to linear sRGB (IEC 61966-2-1), D65.
constexpr double kSrgbFromXyz[3][3] = {
    {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};

constexpr int kNoiseProfile = 51041;

const TIFFFieldInfo kDngFields[] = {
    {kNoiseProfile, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("NoiseProfile")},
};

/// A TIFF file that is being written; every failure throws InputError.
class TiffFile {
 public:
  explicit TiffFile(const std::string& path) : path_(path) {
    file_.reset(TIFFOpenExt(path.c_str(), "wl", quiet_tiff(error_).get()));
    require(file_ != nullptr);
  }

  /// A directory of its own, which DNG prefers and without which LibRaw finds no ISO. Comes before the image's.
  void write_exif(const Capture& capture) {
    require(TIFFCreateEXIFDirectory(file_.get()) == 0);
    set(EXIFTAG_EXPOSURETIME, capture.exposure.time_s);
    set(EXIFTAG_FNUMBER, capture.camera.f_number);
    const double iso = std::clamp(std::round(capture.exposure.iso), 0.0, 65535.0);
    set_array(EXIFTAG_ISOSPEEDRATINGS, std::vector<std::uint16_t>{static_cast<std::uint16_t>(iso)});
    set(EXIFTAG_FOCALLENGTH, capture.camera.focal_length_mm);
    std::uint64_t offset = 0;
    require(TIFFWriteCustomDirectory(file_.get(), &offset) == 1);
    TIFFFreeDirectory(file_.get());  // its fields, which TIFFCreateDirectory() would leak
    require(TIFFCreateDirectory(file_.get()) == 0);
    require(TIFFMergeFieldInfo(file_.get(), kDngFields, std::size(kDngFields)) == 0);
    set(TIFFTAG_EXIFIFD, offset);
  }

  template <typename... Values>
  void set(std::uint32_t tag, Values... values) {
    require(TIFFSetField(file_.get(), tag, values...) == 1);
  }
  template <typename T>
  void set_array(std::uint32_t tag, const std::vector<T>& values) {
    set(tag, static_cast<int>(values.size()), values.data());
  }

  /// The image as one strip, then the directory.
  void write(const ImageU16& image) {
    const auto bytes = static_cast<tmsize_t>(image.data.size() * sizeof(std::uint16_t));
    void* const pixels = const_cast<std::uint16_t*>(image.data.data());  // libtiff only reads from it
    require(TIFFWriteEncodedStrip(file_.get(), 0, pixels, bytes) == bytes);
    require(TIFFWriteDirectory(file_.get()) == 1);
    file_.reset();
    sync_to_disk(path_);
  }

 private:
  void require(bool holds) const {
    if (holds) return;
    const std::string prefix = path_ + ": ";  // of some of libtiff's messages
    const std::string why = error_.starts_with(prefix) ? error_.substr(prefix.size()) : error_;
    throw InputError(fmt::format("{}: cannot be written: {}", printable(final_path(path_)), printable(why)));
  }

  std::string path_, error_;
  std::unique_ptr<TIFF, void (*)(TIFF*)> file_{nullptr, TIFFClose};
};

/// The color filters of the top-left 2 x 2 photosites, and what their values mean.
void set_colors(TiffFile& file, const Capture& capture) {
  file.set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_CFA);
  const std::uint16_t repeat[2] = {2, 2};
  file.set(TIFFTAG_CFAREPEATPATTERNDIM, repeat);
  std::vector<std::uint8_t> filters;
  for (const char letter : capture.camera.cfa) filters.push_back(letter == 'R' ? 0 : letter == 'G' ? 1 : 2);
  file.set_array(TIFFTAG_CFAPATTERN, filters);
  file.set_array(TIFFTAG_CFAPLANECOLOR, std::vector<std::uint8_t>{0, 1, 2});
  constexpr int kRectangular = 1;
  file.set(TIFFTAG_CFALAYOUT, kRectangular);
  // the sensor's color of what is white in the capture's light is that of sRGB's white
  const Matrix3 camera_from_srgb = inverse(capture.exposure.color_matrix.value_or(kIdentity3));
  std::vector<float> camera_from_xyz, neutral;
  for (int c = 0; c < 3; ++c) {
    const double white_balance = capture.exposure.white_balance[c];
    neutral.push_back(static_cast<float>(1 / white_balance));
    for (int xyz = 0; xyz < 3; ++xyz) {
      double weight = 0;
      for (int k = 0; k < 3; ++k) weight += camera_from_srgb[3 * c + k] * kSrgbFromXyz[k][xyz];
      camera_from_xyz.push_back(static_cast<float>(weight / white_balance));
    }
  }
  file.set_array(TIFFTAG_COLORMATRIX1, camera_from_xyz);
  file.set_array(TIFFTAG_ASSHOTNEUTRAL, neutral);
}

}  // namespace

void write_dng(const std::string& path, const ImageU16& raw, const Capture& capture, DngImage image) {
  const Camera& camera = capture.camera;
  const Exposure& exposure = capture.exposure;
  const bool mosaic = image == DngImage::mosaic;
  const bool colors = mosaic || camera.dp_downsample_x * camera.dp_downsample_y == 1;
  const double pixel_height = mosaic ? 1 : static_cast<double>(camera.dp_downsample_y) / camera.dp_downsample_x;
  const NoiseProfile& noise = mosaic ? exposure.mosaic_noise : exposure.dp_noise;
  const double white =
      (mosaic ? exposure.mosaic_white_level_dn : exposure.dp_white_level_dn).value_or(exposure.white_level_dn);
  const double range = white - exposure.black_level_dn;
  constexpr int kLinearRaw = 34892, kD65 = 21;

  TiffFile file(path);
  file.write_exif(capture);
  file.set(TIFFTAG_SUBFILETYPE, 0);  // the main image
  file.set(TIFFTAG_IMAGEWIDTH, raw.width);
  file.set(TIFFTAG_IMAGELENGTH, raw.height);
  file.set(TIFFTAG_BITSPERSAMPLE, 16);
  file.set(TIFFTAG_SAMPLESPERPIXEL, 1);
  file.set(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  file.set(TIFFTAG_ROWSPERSTRIP, raw.height);
  file.set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  file.set(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  file.set(TIFFTAG_MAKE, "dualpixel");
  file.set(TIFFTAG_MODEL, capture.camera.name.c_str());

  const std::uint8_t version[4] = {1, 4, 0, 0}, oldest_reader[4] = {1, 3, 0, 0};
  file.set(TIFFTAG_DNGVERSION, version);
  file.set(TIFFTAG_DNGBACKWARDVERSION, oldest_reader);
  file.set(TIFFTAG_UNIQUECAMERAMODEL, ("dualpixel " + capture.camera.name).c_str());
  file.set_array(TIFFTAG_BLACKLEVEL, std::vector<float>{static_cast<float>(exposure.black_level_dn)});
  file.set_array(TIFFTAG_WHITELEVEL, std::vector<std::uint32_t>{static_cast<std::uint32_t>(std::lround(white))});
  const float scale[2] = {1, static_cast<float>(pixel_height)};
  file.set(TIFFTAG_DEFAULTSCALE, scale);
  file.set(TIFFTAG_CALIBRATIONILLUMINANT1, kD65);
  file.set_array(kNoiseProfile, std::vector<double>{noise.shot_dn / range, noise.read_dn2 / (range * range)});
  if (colors) {
    set_colors(file, capture);
  } else {
    file.set(TIFFTAG_PHOTOMETRIC, kLinearRaw);
  }
  file.write(raw);
}

}  // namespace dualpixel
