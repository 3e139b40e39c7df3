#include "capture/image/npy.h"

#include <fmt/format.h>

#include "capture/files.h"

namespace dualpixel {

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

}  // namespace dualpixel
