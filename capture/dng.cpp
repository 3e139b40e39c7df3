#include "capture/dng.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace dualpixel {
namespace {

template <typename T>
void append(std::string& bytes, T value) {
  static_assert(std::endian::native == std::endian::little);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// A TIFF directory under construction; tags must be added in ascending order (TIFF 6.0, section 2).
class Directory {
 public:
  void bytes(int tag, const std::string& values) { add(tag, 1, values.size(), values); }
  void ascii(int tag, const std::string& text) { add(tag, 2, text.size() + 1, text + '\0'); }
  void shorts(int tag, const std::vector<int>& values) {
    std::string data;
    for (const int value : values) append(data, static_cast<std::uint16_t>(value));
    add(tag, 3, values.size(), data);
  }
  void long_(int tag, std::size_t value) {
    std::string data;
    append(data, static_cast<std::uint32_t>(value));
    add(tag, 4, 1, data);
  }
  void rationals(int tag, const std::vector<double>& values, bool with_sign = false) {
    std::string data;
    for (const double value : values) {
      const std::int32_t denominator = std::abs(value) < 2000 ? 1'000'000 : 1000;
      append(data, static_cast<std::int32_t>(std::lround(std::clamp(value, -2e6, 2e6) * denominator)));
      append(data, denominator);
    }
    add(tag, with_sign ? 10 : 5, values.size(), data);
  }
  void doubles(int tag, const std::vector<double>& values) {
    std::string data;
    for (const double value : values) append(data, value);
    add(tag, 12, values.size(), data);
  }

  /// The file: header, directory, values that don't fit into it, and the strip, whose place the entry of `strip_tag`
  /// gets to hold.
  std::string file(int strip_tag, const void* strip, std::size_t strip_bytes) const {
    constexpr std::size_t kHeader = 8;
    std::size_t next = kHeader + 2 + 12 * entries_.size() + 4;
    std::size_t values_bytes = 0;
    for (const Entry& entry : entries_) values_bytes += place_of(entry).size();
    const std::size_t strip_at = next + values_bytes;

    std::string bytes = "II*", values;
    bytes += '\0';
    append(bytes, static_cast<std::uint32_t>(kHeader));
    append(bytes, static_cast<std::uint16_t>(entries_.size()));
    for (Entry entry : entries_) {
      if (entry.tag == strip_tag) {
        entry.data.clear();
        append(entry.data, static_cast<std::uint32_t>(strip_at));
      }
      append(bytes, static_cast<std::uint16_t>(entry.tag));
      append(bytes, static_cast<std::uint16_t>(entry.type));
      append(bytes, static_cast<std::uint32_t>(entry.count));
      const std::string place = place_of(entry);
      if (place.empty()) {
        entry.data.resize(4);
        bytes += entry.data;
      } else {
        append(bytes, static_cast<std::uint32_t>(next));
        next += place.size();
        values += place;
      }
    }
    append(bytes, std::uint32_t{0});
    bytes += values;
    bytes.append(static_cast<const char*>(strip), strip_bytes);
    return bytes;
  }

 private:
  struct Entry {
    int tag, type;
    std::size_t count;
    std::string data;
  };

  void add(int tag, int type, std::size_t count, const std::string& data) {
    entries_.push_back({tag, type, count, data});
  }
  /// What of an entry lies outside of the directory, on an even address.
  static std::string place_of(const Entry& entry) {
    if (entry.data.size() <= 4) return "";
    return entry.data.size() % 2 ? entry.data + '\0' : entry.data;
  }

  std::vector<Entry> entries_;
};

/// From CIE XYZ to linear sRGB (IEC 61966-2-1), D65.
constexpr double kSrgbFromXyz[3][3] = {
    {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};

}  // namespace

std::string dng(const ImageU16& raw, const Capture& capture, bool mosaic, const NoiseProfile& noise,
                double pixel_height) {
  const Exposure& exposure = capture.exposure;
  const std::size_t strip_bytes = raw.data.size() * sizeof(std::uint16_t);
  const double range = exposure.white_level_dn - exposure.black_level_dn;
  constexpr int kColorFilterArray = 32803, kLinearRaw = 34892, kD65 = 21;

  Directory d;
  d.long_(254, 0);  // NewSubfileType: the main image
  d.long_(256, raw.width);
  d.long_(257, raw.height);
  d.shorts(258, {16});  // BitsPerSample
  d.shorts(259, {1});   // Compression: none
  d.shorts(262, {mosaic ? kColorFilterArray : kLinearRaw});
  d.ascii(271, "dualpixel");          // Make
  d.ascii(272, capture.camera.name);  // Model
  d.long_(273, 0);                    // StripOffsets
  d.shorts(274, {1});                 // Orientation: upright
  d.shorts(277, {1});                 // SamplesPerPixel
  d.long_(278, raw.height);           // RowsPerStrip
  d.long_(279, strip_bytes);          // StripByteCounts
  d.shorts(284, {1});                 // PlanarConfiguration
  if (mosaic) {
    d.shorts(33421, {2, 2});  // CFARepeatPatternDim
    std::string colors;
    for (const char letter : capture.camera.cfa) colors += static_cast<char>(letter == 'R' ? 0 : letter == 'G' ? 1 : 2);
    d.bytes(33422, colors);  // CFAPattern
  }
  d.rationals(33434, {exposure.time_s});
  d.rationals(33437, {capture.camera.f_number});
  d.shorts(34855, {static_cast<int>(std::clamp(std::round(exposure.iso), 0.0, 65535.0))});
  d.rationals(37386, {capture.camera.focal_length_mm});
  d.bytes(50706, std::string("\1\4\0\0", 4));  // DNGVersion
  d.bytes(50707, std::string("\1\3\0\0", 4));  // DNGBackwardVersion
  d.ascii(50708, "dualpixel " + capture.camera.name);
  if (mosaic) {
    d.bytes(50710, std::string("\0\1\2", 3));  // CFAPlaneColor
    d.shorts(50711, {1});                      // CFALayout: rectangular
  }
  d.rationals(50714, {exposure.black_level_dn});
  d.long_(50717, static_cast<std::size_t>(std::lround(exposure.white_level_dn)));
  d.rationals(50718, {1, pixel_height});  // DefaultScale
  if (mosaic) {
    std::vector<double> camera_from_xyz, neutral;
    for (int c = 0; c < 3; ++c) {
      neutral.push_back(1 / exposure.white_balance[c]);
      for (int i = 0; i < 3; ++i) camera_from_xyz.push_back(kSrgbFromXyz[c][i] / exposure.white_balance[c]);
    }
    d.rationals(50721, camera_from_xyz, true);  // ColorMatrix1
    d.rationals(50728, neutral);                // AsShotNeutral
  }
  d.shorts(50778, {kD65});                                                      // CalibrationIlluminant1
  d.doubles(51041, {noise.shot_dn / range, noise.read_dn2 / (range * range)});  // NoiseProfile
  return d.file(273, raw.data.data(), strip_bytes);
}

}  // namespace dualpixel
