#include "scenes/textures/paint.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "capture/image/image_io.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

/// Deviation of noise() in the plane: that of a uniform number (1/12) times the mean of the squares of its four
/// weights, (26/35)^2 for the fade 3t^2 - 2t^3.
constexpr float kDeviation = 0.2145f;

/// lround(255 srgb_from_linear(x)) by a table, since textures have millions of texels; x below 0 counts as 0, above 1
/// as 1.
class SrgbBytes {
 public:
  SrgbBytes() {
    for (int byte = 1; byte < 256; ++byte) {  // floats of one sign are in the order of their bits
      std::uint32_t below = 0, above = std::bit_cast<std::uint32_t>(1.0f);
      while (above - below > 1) {
        const std::uint32_t middle = (below + above) / 2;
        (std::lround(255 * srgb_from_linear(std::bit_cast<float>(middle))) < byte ? below : above) = middle;
      }
      smallest_[byte] = std::bit_cast<float>(above);
    }
    smallest_[256] = 2;
    int byte = 0;
    for (int step = 0; step <= kSteps; ++step) {
      while (smallest_[byte + 1] <= static_cast<float>(step) / kSteps) ++byte;
      at_step_[step] = static_cast<std::uint8_t>(byte);
    }
  }

  std::uint8_t operator()(float linear) const {
    const float x = linear > 0 ? std::min(linear, 1.0f) : 0;
    int byte = at_step_[static_cast<int>(x * kSteps)];
    while (x >= smallest_[byte + 1]) ++byte;
    return static_cast<std::uint8_t>(byte);
  }

 private:
  static constexpr int kSteps = 4096;  // a step is less than a byte
  std::array<float, 257> smallest_{};  ///< value of each byte
  std::array<std::uint8_t, kSteps + 1> at_step_;
};

}  // namespace

Texture paint(int size, const std::function<glm::vec3(float, float)>& linear_color) {
  static const SrgbBytes to_byte;
  Texture texture{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size) * size * 3)};
  tbb::parallel_for(0, size, [&](int y) {
    for (int x = 0; x < size; ++x) {
      const float step = 1.0f / static_cast<float>(size);
      const glm::vec3 color =
          linear_color((static_cast<float>(x) + 0.5f) * step, (static_cast<float>(y) + 0.5f) * step);
      std::uint8_t* texel = &texture.rgb[(static_cast<std::size_t>(y) * size + x) * 3];
      for (int c = 0; c < 3; ++c) texel[c] = to_byte(color[c]);
    }
  });
  return texture;
}

PinkNoise::PinkNoise(std::uint32_t seed, int lowest, int highest, float slope, int along_u, int along_v) {
  const float gain = std::exp2(1 - slope);
  float variance = 0, weight = 1;
  for (int cells = lowest; cells == lowest || cells <= highest; cells *= 2, weight *= gain) {
    Octave octave{cells * along_u, cells * along_v, weight, {}};
    for (int j = 0; j <= octave.rows; ++j) {
      for (int i = 0; i <= octave.columns; ++i)
        octave.corners.push_back(hash01(seed, i == octave.columns ? 0 : i, j == octave.rows ? 0 : j));
    }
    octaves_.push_back(std::move(octave));
    variance += weight * weight;
    ++seed;
  }
  scale_ = 1 / (kDeviation * std::sqrt(variance));
}

float PinkNoise::operator()(float u, float v) const {
  u -= std::floor(u), v -= std::floor(v);
  float sum = 0;
  for (const Octave& octave : octaves_) {
    const float x = u * static_cast<float>(octave.columns), y = v * static_cast<float>(octave.rows);
    const int i = std::min(static_cast<int>(x), octave.columns - 1), j = std::min(static_cast<int>(y), octave.rows - 1);
    const float tx = x - static_cast<float>(i), ty = y - static_cast<float>(j);
    const float a = tx * tx * (3 - 2 * tx), b = ty * ty * (3 - 2 * ty);
    const float* corner = &octave.corners[static_cast<std::size_t>(j) * (octave.columns + 1) + i];
    const float* below = corner + octave.columns + 1;
    const float top = corner[0] * (1 - a) + corner[1] * a, bottom = below[0] * (1 - a) + below[1] * a;
    sum += octave.weight * (top * (1 - b) + bottom * b - 0.5f);
  }
  return sum * scale_;
}

glm::vec3 shaded(glm::vec3 color, float contrast, float n) { return color * std::exp(contrast * n); }

}  // namespace dualpixel::scenes
