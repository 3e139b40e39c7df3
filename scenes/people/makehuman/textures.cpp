#include "scenes/people/makehuman/textures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "scenes/people/makehuman/text_lines.h"
#include "simulator/render/shading/surface.h"

namespace dualpixel::scenes {
namespace {

namespace fs = std::filesystem;

}  // namespace

std::shared_ptr<const simulator::Texture> read_texture(const std::string& path, vec3& mean) {
  constexpr int kMostSide = 4096;
  const PictureSize size = picture_size(path);
  if (size.width > kMostSide || size.height > kMostSide) {
    throw InputError(fmt::format("{}: {} x {} pixels; textures of up to {} a side are read", printable(path),
                                 size.width, size.height, kMostSide));
  }
  const Image image = read_image(path);
  auto texture = std::make_shared<simulator::Texture>();
  texture->width = image.width;
  texture->height = image.height;
  texture->srgb = true;
  texture->rgba.resize(image.pixel_count() * 4);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (int c = 0; c < 4; ++c) {
      const int from = c < 3 ? (image.channels < 3 ? 0 : c) : image.channels - 1;
      const bool opaque = c == 3 && image.channels != 4 && image.channels != 2;
      const float value = opaque ? 1 : image.data[i * image.channels + from];
      texture->rgba[4 * i + c] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
    }
  }
  simulator::keep_decoded(*texture);
  glm::vec4 sum(0);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const glm::vec4 texel = simulator::decode_texel(*texture, i);
    sum += texel.w > 0.5f ? glm::vec4(vec3(texel), 1) : glm::vec4(0);
  }
  mean = sum.w > 0 ? vec3(sum) / sum.w : vec3(0.5f);
  return texture;
}

std::shared_ptr<const simulator::Texture> material_texture(const std::string& path, vec3& mean) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return nullptr;
  TextLines lines(path);
  std::vector<std::string_view> words;
  while (lines.next(words)) {
    if (words[0] != "diffuseTexture" || words.size() < 2) continue;
    const std::string name(words[1]);
    if (name.find("..") != std::string::npos || name.front() == '/')
      lines.fail("a texture must lie beside its material");
    const fs::path texture = fs::path(path).parent_path() / name;
    return fs::is_regular_file(texture, ignored) ? read_texture(texture.string(), mean) : nullptr;
  }
  return nullptr;
}

}  // namespace dualpixel::scenes
