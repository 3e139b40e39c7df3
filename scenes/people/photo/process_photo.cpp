#include "scenes/people/photo/process_photo.h"

#include <algorithm>
#include <cmath>

#include "capture/image/image_io.h"

namespace dualpixel::scenes {
namespace {

float luminance(const float* rgb) { return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]; }

/// Normal deviate of a pixel from two hashes (Box & Muller 1958).
float deviate(std::uint64_t key) {
  const std::uint64_t bits = simulator::hash(key);
  const float u = std::max(simulator::unit_float(static_cast<std::uint32_t>(bits)), 1e-7f);
  const float v = simulator::unit_float(static_cast<std::uint32_t>(bits >> 32));
  return std::sqrt(-2 * std::log(u)) * std::cos(6.2831853f * v);
}

/// Adds `amount` of the difference to a 3 x 3 mean: above 0 sharpens, below softens.
void sharpen(Image& image, float amount) {
  const Image before = image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        float sum = 0;
        for (int j = -1; j <= 1; ++j) {
          for (int i = -1; i <= 1; ++i) {
            sum += before.at(std::clamp(x + i, 0, image.width - 1), std::clamp(y + j, 0, image.height - 1), c);
          }
        }
        image.at(x, y, c) += amount * (before.at(x, y, c) - sum / 9);
      }
    }
  }
}

}  // namespace

void set_mean_luminance(Image& light, const Image& weight, float mean) {
  double sum = 0, total = 0;
  for (std::size_t i = 0; i < light.pixel_count(); ++i) {
    double w = 1;
    if (!weight.empty()) {
      w = 0;
      for (int c = 0; c < weight.channels; ++c) w += weight.data[i * weight.channels + c];
    }
    // single lamps must not darken everything else
    sum += w * std::min(luminance(&light.data[3 * i]), 3.0f);
    total += w;
  }
  if (sum <= 0) return;
  const auto gain = static_cast<float>(mean * total / sum);
  for (float& value : light.data) value *= gain;
}

std::vector<std::uint8_t> process_photo(Image light, RandomStream rng) {
  const float warm = 0.2f * rng.normal(), green = 0.05f * rng.normal();
  const float gain[3] = {std::exp2(warm), std::exp2(green), std::exp2(-warm)};
  const float saturation = std::clamp(1 + 0.18f * rng.normal(), 0.4f, 1.6f);
  const bool gray = rng.chance(0.03f);
  const float contrast = std::clamp(0.25f + 0.25f * rng.normal(), -0.3f, 0.9f),
              lift = rng.chance(0.15f) ? rng.uniform(0, 0.06f) : 0;
  // electrons of a white pixel of the small picture: a phone's 6000 over ISO, times the photosites it is the mean of
  const float white_e = 6000 / std::exp2(rng.uniform(0, 5)) * rng.uniform(4, 60);
  const float read_e = 2.5f;
  const float vignette = rng.chance(0.4f) ? rng.uniform(0, 0.4f) : 0;
  const float sharp = rng.chance(0.5f) ? rng.uniform(0, 0.8f) : -rng.uniform(0, 1);
  const std::uint64_t seed = rng.seed();
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      float* rgb = &light.at(x, y, 0);
      const float dx = (static_cast<float>(x) + 0.5f) / static_cast<float>(light.width) - 0.5f;
      const float dy = (static_cast<float>(y) + 0.5f) / static_cast<float>(light.height) - 0.5f;
      const float shade = 1 - vignette * 2 * (dx * dx + dy * dy);
      const std::uint64_t key = simulator::hash(seed, static_cast<std::uint64_t>(y) * light.width + x);
      for (int c = 0; c < 3; ++c) {
        const float electrons = std::max(rgb[c] * gain[c] * shade, 0.0f) * white_e;
        rgb[c] = (electrons + std::sqrt(electrons + read_e * read_e) * deviate(key + c)) / white_e;
      }
      const float gray_level = luminance(rgb);
      for (int c = 0; c < 3; ++c) {
        const float value = gray ? gray_level : gray_level + saturation * (rgb[c] - gray_level);
        const float code = srgb_from_linear(value);
        const float curved = code + contrast * (code * code * (3 - 2 * code) - code);
        rgb[c] = lift + (1 - lift) * curved;
      }
    }
  }
  sharpen(light, sharp);
  std::vector<std::uint8_t> out(light.data.size());
  std::transform(light.data.begin(), light.data.end(), out.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
  });
  return out;
}

}  // namespace dualpixel::scenes
