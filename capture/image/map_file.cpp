#include "capture/image/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"

namespace dualpixel {
namespace {

constexpr int kLongestMapSide = 65536;

/// Portable float map: "Pf", width, height, a scale whose sign tells the byte order (negative: little endian), a single
/// white space, then float32 from the bottom row up.
Image read_pfm(const std::string& path) {
  const std::string bytes = read_file(path);
  const auto refuse = [&](const std::string& why) { throw InputError(printable(path) + ": " + why); };
  std::istringstream head(bytes.substr(0, 200));
  std::string kind;
  std::int64_t width = 0, height = 0;
  double scale = 0;
  if (!(head >> kind >> width >> height >> scale) || scale == 0) refuse("is not a whole PFM file");
  if (kind != "Pf") refuse("is a PFM of three channels; one is needed");
  if (width < 1 || height < 1 || width > kLongestMapSide || height > kLongestMapSide) {
    refuse(fmt::format("{} x {} pixels: 1 to {} a side are allowed", width, height, kLongestMapSide));
  }
  if (scale > 0) refuse("is a big-endian PFM; write it little endian (a negative scale)");
  const auto start = static_cast<std::size_t>(head.tellg()) + 1;
  const auto row = static_cast<std::size_t>(width) * sizeof(float);
  if (bytes.size() < start + row * height) refuse("ends before its last pixel");
  Image map(static_cast<int>(width), static_cast<int>(height));
  for (int y = 0; y < map.height; ++y) {
    std::memcpy(map.row(map.height - 1 - y), bytes.data() + start + row * y, row);
  }
  return map;
}

Image read_integers(const std::string& path, const std::optional<IntegerScale>& integers) {
  if (!integers) throw InputError(printable(path) + ": holds integers: give --scale, and --offset where 0 is not 0");
  const ImageU16 stored = read_image_u16(path, 1);
  Image map(stored.width, stored.height);
  std::transform(stored.data.begin(), stored.data.end(), map.data.begin(),
                 [&](std::uint16_t value) { return static_cast<float>(integers->scale * value + integers->offset); });
  return map;
}

enum class MapKind { npy, pfm, picture };

MapKind map_kind(const std::string& path) {
  require_regular_file(path);
  char bytes[6] = {};
  std::ifstream(path, std::ios::binary).read(bytes, sizeof(bytes));
  const std::string_view head(bytes, sizeof(bytes));
  if (head == "\x93NUMPY") return MapKind::npy;
  return head.starts_with("Pf") || head.starts_with("PF") ? MapKind::pfm : MapKind::picture;
}

}  // namespace

bool is_integer_picture(const std::string& path) {
  return map_kind(path) == MapKind::picture && picture_size(path).format != "openexr";
}

Image read_map(const std::string& path, const std::string& channel, const std::optional<IntegerScale>& integers) {
  const MapKind kind = map_kind(path);
  if (kind == MapKind::npy) {
    Image map = read_npy(path);
    if (map.channels == 1) return map;
    throw InputError(fmt::format("{}: has {} channels; one is needed", printable(path), map.channels));
  }
  if (kind == MapKind::pfm) return read_pfm(path);
  const PictureSize picture = picture_size(path);
  if (picture.format != "openexr") return read_integers(path, integers);
  const bool named = std::find(picture.channels.begin(), picture.channels.end(), channel) != picture.channels.end();
  if (!named && picture.channels.size() > 1) {
    throw InputError(fmt::format("{}: has the channels {}; must have '{}', or one alone", printable(path),
                                 printable(fmt::format("{}", fmt::join(picture.channels, ", "))), channel));
  }
  return std::move(read_exr(path, {named ? channel : picture.channels.front()}).front());
}

Image read_confidence(const std::string& path) {
  return is_integer_picture(path) ? read_image(path) : read_map(path, "confidence");
}

}  // namespace dualpixel
