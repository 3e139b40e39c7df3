#include <array>
#include <cmath>

#include "simulator/scene/scene.h"

namespace dualpixel::simulator {
namespace {

/// sRGB decoding (IEC 61966-2-1) of bytes, and the plain scaling of linear ones.
struct DecodeTables {
  std::array<float, 256> srgb;
  std::array<float, 256> linear;
  DecodeTables() {
    for (int i = 0; i < 256; ++i) {
      const double x = i / 255.0;
      linear[i] = static_cast<float>(x);
      srgb[i] = static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
    }
  }
};
const DecodeTables kDecode;

}  // namespace

glm::vec4 decode_texel(const Texture& texture, std::size_t index) {
  const auto& color = texture.srgb ? kDecode.srgb : kDecode.linear;
  const std::uint8_t* t = &texture.rgba[4 * index];
  return {color[t[0]], color[t[1]], color[t[2]], kDecode.linear[t[3]]};
}

void keep_decoded(Texture& texture) {
  constexpr std::size_t kMostTexels = 1 << 22;
  const std::size_t texels = texture.rgba.size() / 4;
  if (texels > kMostTexels) return;
  texture.decoded.resize(texels);
  for (std::size_t i = 0; i < texels; ++i) texture.decoded[i] = decode_texel(texture, i);
}

}  // namespace dualpixel::simulator
