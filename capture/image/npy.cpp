#include "capture/image/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "capture/error.h"
#include "capture/files.h"

namespace dualpixel {
namespace {

constexpr std::size_t kLongestArraySide = 65536, kMostArrayChannels = 4;

[[noreturn]] void refuse_npy(const std::string& path, const std::string& why) {
  throw InputError(printable(path) + ": " + why);
}

/// The text of the header's entry `key`, up to `end`.
std::string header_entry(const std::string& path, std::string_view header, const std::string& key, char end) {
  const std::size_t found = header.find("'" + key + "':");
  const std::size_t last = found == std::string_view::npos ? found : header.find(end, found + key.size() + 4);
  if (last == std::string_view::npos) refuse_npy(path, "is not a NumPy file that can be read: no '" + key + "'");
  const std::size_t first = header.find_first_not_of(' ', found + key.size() + 3);
  return std::string(header.substr(first, last - first));
}

/// (height, width, channels) of "(480, 640" or the like.
std::array<std::size_t, 3> shape_of(const std::string& path, const std::string& text) {
  std::vector<std::size_t> sides;
  bool is_tuple = text.starts_with('(');
  for (std::string_view rest = std::string_view(text).substr(is_tuple); is_tuple && !rest.empty();) {
    const std::size_t comma = rest.find(',');
    const std::string_view item = rest.substr(0, comma);
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
    const std::size_t first = item.find_first_not_of(' ');
    if (first == std::string_view::npos && rest.empty()) break;  // (7,)
    std::size_t side = 0;
    const char *const begin = item.data() + std::min(first, item.size()), *const end = item.data() + item.size();
    const auto [after, error] = std::from_chars(begin, end, side);
    const std::string_view unit(after, static_cast<std::size_t>(end - after));
    is_tuple = error == std::errc() && (unit.empty() || unit == "L");  // Python 2 writes 480L
    sides.push_back(side);
  }
  while (sides.size() > 2 && sides.front() == 1) sides.erase(sides.begin());
  if (sides.size() == 2) sides.push_back(1);
  const bool fits = is_tuple && sides.size() == 3 && sides[0] >= 1 && sides[1] >= 1 && sides[2] >= 1 &&
                    sides[0] <= kLongestArraySide && sides[1] <= kLongestArraySide && sides[2] <= kMostArrayChannels;
  if (!fits) {
    refuse_npy(path, fmt::format("has the shape {}); must be (height, width) or (height, width, channels), with at "
                                 "most {} channels",
                                 printable(text), kMostArrayChannels));
  }
  return {sides[0], sides[1], sides[2]};
}

template <typename T>
void convert(std::string_view bytes, Image& image) {
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    image.data[i] = static_cast<float>(value);
  }
}

struct ArrayType {
  const char* name;
  std::size_t bytes;
  void (*convert)(std::string_view bytes, Image& image);
};
constexpr ArrayType kArrayTypes[] = {{"'<f4'", 4, convert<float>},         {"'<f8'", 8, convert<double>},
                                     {"'|u1'", 1, convert<std::uint8_t>},  {"'|i1'", 1, convert<std::int8_t>},
                                     {"'<u2'", 2, convert<std::uint16_t>}, {"'<i2'", 2, convert<std::int16_t>},
                                     {"'<u4'", 4, convert<std::uint32_t>}, {"'<i4'", 4, convert<std::int32_t>}};

}  // namespace

std::string npy_bytes(const std::string& type, const std::vector<std::size_t>& shape, std::string_view bytes) {
  std::string sizes;
  for (const std::size_t size : shape) sizes += fmt::format("{}, ", size);
  if (shape.size() > 1) sizes.resize(sizes.size() - 2);
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, sizes);
  constexpr std::size_t kBefore = 10;  // magic, version, length
  header.append(63 - (kBefore + header.size()) % 64, ' ');
  header += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  out += static_cast<char>(header.size() & 255);
  out += static_cast<char>(header.size() >> 8);
  out += header;
  out.append(bytes);
  return out;
}

void write_npy(const std::string& path, const Image& image) {
  std::vector<std::size_t> shape = {static_cast<std::size_t>(image.height), static_cast<std::size_t>(image.width)};
  if (image.channels > 1) shape.push_back(static_cast<std::size_t>(image.channels));
  const auto* values = reinterpret_cast<const char*>(image.data.data());
  write_file(path, npy_bytes("<f4", shape, {values, image.data.size() * sizeof(float)}));
}

Image read_npy(const std::string& path) {
  const std::string file = read_file(path);
  const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(file[i])); };
  if (file.size() < 12 || !file.starts_with("\x93NUMPY")) refuse_npy(path, "is not a NumPy file");
  const bool first_version = byte(6) == 1;  // later ones have a length of four bytes
  const std::size_t start = first_version ? 10 : 12;
  const std::size_t length = byte(8) + (byte(9) << 8) + (first_version ? 0 : (byte(10) << 16) + (byte(11) << 24));
  if (file.size() < start + length) refuse_npy(path, "ends before its header does");
  const std::string_view header(file.data() + start, length);
  const std::string type = header_entry(path, header, "descr", ',');
  const auto* const found = std::find_if(std::begin(kArrayTypes), std::end(kArrayTypes),
                                         [&](const ArrayType& row) { return type == row.name; });
  if (found == std::end(kArrayTypes)) {
    refuse_npy(path, "holds " + printable(type) + "; must be float32, float64 or integers, little endian");
  }
  if (header_entry(path, header, "fortran_order", ',') != "False") {
    refuse_npy(path, "is in Fortran order; save numpy.ascontiguousarray() of it");
  }
  const auto [height, width, channels] = shape_of(path, header_entry(path, header, "shape", ')'));
  if (file.size() < start + length + height * width * channels * found->bytes) {
    refuse_npy(path, "ends before its last value");  // before memory is taken for what is not there
  }
  Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels));
  found->convert(std::string_view(file).substr(start + length), image);
  return image;
}

}  // namespace dualpixel
