#include "scenes/textures/paint.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "capture/image/image_io.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

/// Deviation of noise() in the plane: that of a uniform number (1/12) times the mean of the squares of its four
/// weights, (26/35)^2 for the fade 3t^2 - 2t^3.
constexpr float kDeviation = 0.2145f;

}  // namespace

Texture paint(int size, const std::function<glm::vec3(float, float)>& linear_color) {
  Texture texture{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size) * size * 3)};
  tbb::parallel_for(0, size, [&](int y) {
    for (int x = 0; x < size; ++x) {
      const float step = 1.0f / static_cast<float>(size);
      const glm::vec3 color =
          linear_color((static_cast<float>(x) + 0.5f) * step, (static_cast<float>(y) + 0.5f) * step);
      std::uint8_t* texel = &texture.rgb[(static_cast<std::size_t>(y) * size + x) * 3];
      for (int c = 0; c < 3; ++c) {
        texel[c] = static_cast<std::uint8_t>(srgb_from_linear(std::clamp(color[c], 0.0f, 1.0f)) * 255 + 0.5f);
      }
    }
  });
  return texture;
}

PinkNoise::PinkNoise(std::uint32_t seed, int lowest, int highest, float slope)
    : seed_(seed), lowest_(lowest), octaves_(1), gain_(std::exp2(1 - slope)), scale_(1) {
  float variance = 1, weight = 1;
  for (int cells = 2 * lowest; cells <= highest; cells *= 2) {
    weight *= gain_;
    variance += weight * weight;
    ++octaves_;
  }
  scale_ = 1 / (kDeviation * std::sqrt(variance));
}

float PinkNoise::operator()(float u, float v) const { return stretched(u, v, 1, 1); }

float PinkNoise::stretched(float u, float v, int along_u, int along_v) const {
  float sum = 0, weight = 1;
  int cells = lowest_;
  for (int octave = 0; octave < octaves_; ++octave, cells *= 2, weight *= gain_) {
    const int nu = cells * along_u, nv = cells * along_v;
    const float x = (u - std::floor(u)) * static_cast<float>(nu), y = (v - std::floor(v)) * static_cast<float>(nv);
    const int i = std::min(static_cast<int>(x), nu - 1), j = std::min(static_cast<int>(y), nv - 1);
    const float tx = x - static_cast<float>(i), ty = y - static_cast<float>(j);
    const float a = tx * tx * (3 - 2 * tx), b = ty * ty * (3 - 2 * ty);
    const std::uint32_t seed = seed_ + static_cast<std::uint32_t>(octave);
    const int right = i + 1 == nu ? 0 : i + 1, down = j + 1 == nv ? 0 : j + 1;
    const float top = hash01(seed, i, j) * (1 - a) + hash01(seed, right, j) * a;
    const float bottom = hash01(seed, i, down) * (1 - a) + hash01(seed, right, down) * a;
    sum += weight * (top * (1 - b) + bottom * b - 0.5f);
  }
  return sum * scale_;
}

glm::vec3 shaded(glm::vec3 color, float contrast, float n) { return color * std::exp(contrast * n); }

}  // namespace dualpixel::scenes
