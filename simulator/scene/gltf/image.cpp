#include "simulator/scene/gltf/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <istream>
#include <memory>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

#include "capture/error.h"
#include "capture/image/faults/png_fault.h"
#include "simulator/scene/gltf/check.h"
#include "simulator/scene/paged_bytes.h"

namespace dualpixel::simulator {
namespace {

constexpr int kLongestSide = 16384;
constexpr std::int64_t kMostTexels = std::int64_t{1} << 32;
constexpr int kStripRows = 64;  // that are decoded at a time

/// OpenImageIO's name of an image's format by its magic bytes; "" for what glTF does not allow.
std::string format_of(const std::vector<unsigned char>& bytes) {
  using namespace std::string_view_literals;
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (head.starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
  if (head.starts_with("\xff\xd8\xff"sv)) return "jpeg";
  return "";
}

/// Bytes in memory, to be read as a stream.
struct MemoryBuffer : std::streambuf {
  explicit MemoryBuffer(const std::vector<unsigned char>& bytes) {
    char* first = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));  // only read
    setg(first, first, first + bytes.size());
  }
};

[[noreturn]] void fail(const GltfFile& file, int image, const std::string& message) {
  fail_gltf(file.name, fmt::format("/images/{}", image), message);
}

const std::vector<unsigned char>& bytes_of(const GltfFile& file, int image) {
  return file.model.images[static_cast<std::size_t>(image)].image;
}

void check_bytes(const GltfFile& file, int image) {
  const std::vector<unsigned char>& bytes = bytes_of(file, image);
  const std::string format = format_of(bytes);
  if (format.empty()) fail(file, image, "must be a PNG or JPEG image");
  if (format != "png") return;
  MemoryBuffer buffer(bytes);
  std::istream png(&buffer);
  if (const auto fault = fault_of_png(png)) fail(file, image, "cannot be decoded: " + *fault);
}

/// An image whose header has been read.
struct OpenImage {
  OIIO::Filesystem::IOMemReader memory;
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageSpec spec;

  OpenImage(const GltfFile& file, int image)
      : memory(const_cast<unsigned char*>(bytes_of(file, image).data()), bytes_of(file, image).size()) {  // only read
    const std::string format = format_of(bytes_of(file, image));
    input = OIIO::ImageInput::create(format);
    if (!input || !input->set_ioproxy(&memory)) fail(file, image, "this build of OpenImageIO cannot read " + format);
    OIIO::ImageSpec as_stored;
    as_stored["oiio:UnassociatedAlpha"] = 1;
    if (!input->open("image." + format, spec, as_stored)) fail(file, image, "cannot be decoded: " + fault());
  }
  std::string fault() const { return printable(input->geterror().substr(0, 200)); }
};

/// The size, before a small file can unpack to gigabytes.
void read_size(const GltfFile& file, int image, Texture& texture) {
  const OIIO::ImageSpec spec = OpenImage(file, image).spec;
  if (spec.width < 1 || spec.height < 1 || spec.width > kLongestSide || spec.height > kLongestSide ||
      spec.nchannels < 1 || spec.nchannels > 4) {
    fail(file, image,
         fmt::format("{} x {} texels of {} channels: must be 1 to {} a side, of 1 to 4 channels", spec.width,
                     spec.height, spec.nchannels, kLongestSide));
  }
  texture.width = spec.width;
  texture.height = spec.height;
}

std::uint8_t* make_room(Texture& texture, bool paged) {
  const std::size_t bytes = std::size_t{4} * texture.width * texture.height;
  if (!paged) {
    texture.rgba.resize(bytes);
    return texture.rgba.data();
  }
  const std::shared_ptr<std::uint8_t[]> room = paged_bytes(bytes);
  texture.paged = room;
  return room.get();
}

void decode(const GltfFile& file, int image, bool paged, Texture& texture) {
  OpenImage open(file, image);
  const OIIO::ImageSpec& spec = open.spec;
  const bool color = spec.nchannels >= 3;
  const bool alpha = spec.nchannels % 2 == 0;
  std::uint8_t* to = nullptr;
  std::vector<std::uint8_t> strip(static_cast<std::size_t>(spec.width) * spec.nchannels * kStripRows);
  for (int y = 0; y < spec.height; y += kStripRows) {
    const int end = std::min(y + kStripRows, spec.height);
    if (!open.input->read_scanlines(0, 0, y, end, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, strip.data())) {
      fail(file, image, "cannot be decoded: " + open.fault());
    }
    if (y == 0) to = make_room(texture, paged);  // a header alone is not believed
    const std::uint8_t* from = strip.data();
    for (std::int64_t i = 0; i < std::int64_t{end - y} * spec.width; ++i, from += spec.nchannels, to += 4) {
      for (int c = 0; c < 3; ++c) to[c] = from[color ? c : 0];
      to[3] = alpha ? from[spec.nchannels - 1] : 255;
    }
  }
}

/// Whether decoding takes little memory, by the header: others buffer whole pictures, whatever their bytes hold.
bool is_small_png(const std::vector<unsigned char>& bytes) {
  constexpr std::uint64_t kFewTexels = 1 << 22;
  constexpr std::size_t kSizeAt = 16;  // of width and height, big-endian
  if (format_of(bytes) != "png" || bytes.size() < kSizeAt + 8) return false;
  std::uint64_t side[2] = {0, 0};
  for (std::size_t i = 0; i < 8; ++i) side[i / 4] = side[i / 4] << 8 | bytes[kSizeAt + i];
  return side[0] * side[1] <= kFewTexels;
}

/// Does `work(i)` for each of `images`, on all threads for small ones and one by one for the others. Throws what the
/// first of those that failed threw; later ones need not be done.
void for_each_image(const GltfFile& file, std::span<const int> images, const std::function<void(std::size_t)>& work) {
  std::vector<std::exception_ptr> faults(images.size());
  std::atomic<std::size_t> first_fault = images.size();
  const auto try_one = [&](std::size_t i) {
    if (i > first_fault) return;
    try {
      work(i);
    } catch (...) {
      faults[i] = std::current_exception();
      for (std::size_t known = first_fault; i < known && !first_fault.compare_exchange_weak(known, i);) continue;
    }
  };
  const auto is_small = [&](std::size_t i) { return is_small_png(bytes_of(file, images[i])); };
  tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t i) {
    if (is_small(i)) try_one(i);
  });
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (!is_small(i)) try_one(i);
  }
  if (first_fault < images.size()) std::rethrow_exception(faults[first_fault]);
}

}  // namespace

void decode_images(const GltfFile& file, std::span<const int> images, std::span<Texture> textures,
                   std::int64_t texels_in_memory) {
  for_each_image(file, images, [&](std::size_t i) {
    check_bytes(file, images[i]);
    read_size(file, images[i], textures[i]);
  });
  std::vector<char> paged;  // by the sizes of those before it, whichever is decoded first
  std::int64_t in_all = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Texture& texture = textures[i];
    const std::int64_t texels = std::int64_t{texture.width} * texture.height;
    in_all += texels;
    if (in_all > kMostTexels) {
      fail(file, images[i],
           fmt::format("{} x {} texels: all textures together must have at most {}", texture.width, texture.height,
                       kMostTexels));
    }
    paged.push_back(texels > texels_in_memory);
    if (!paged.back()) texels_in_memory -= texels;
  }
  for_each_image(file, images, [&](std::size_t i) { decode(file, images[i], paged[i] != 0, textures[i]); });
}

}  // namespace dualpixel::simulator
