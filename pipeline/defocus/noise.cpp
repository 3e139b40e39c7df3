#include "pipeline/defocus/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "capture/image/demosaic.h"
#include "capture/image/rows.h"
#include "capture/matrix3.h"
#include "pipeline/burst/merge.h"
#include "pipeline/edge_aware/filter_mask.h"

namespace dualpixel::pipeline {
namespace {

/// Counter-based random bits: Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number Generators" (SplitMix64).
std::uint64_t random_bits(std::uint64_t counter) {
  std::uint64_t z = (counter + 1) * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

/// White Gaussian noise, standard deviation 1 (Box and Muller 1958).
Image white_noise(int width, int height, std::uint64_t seed) {
  const std::uint64_t stream = random_bits(seed);
  Image noise(width, height);
  for (std::size_t i = 0; i < noise.data.size(); ++i) {
    const std::uint64_t bits = random_bits(stream + i);
    const double u = (static_cast<double>(bits >> 32) + 0.5) * 0x1p-32;
    const double v = static_cast<double>(bits & 0xffffffffu) * 0x1p-32;
    noise.data[i] = static_cast<float>(std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v));
  }
  return noise;
}

void high_pass(Image& rgb, float sigma_px) {
  Image plane(rgb.width, rgb.height);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < plane.data.size(); ++i) plane.data[i] = rgb.data[3 * i + c];
    const Image coarse = gaussian_blur(plane, sigma_px);
    for (std::size_t i = 0; i < plane.data.size(); ++i) rgb.data[3 * i + c] -= coarse.data[i];
  }
}

NoisePatch make_patch(std::uint64_t seed, int period, const NoiseOptions& options) {
  const int side = period + options.feather_px;
  Image field = demosaic(white_noise(side, side, seed), "RGGB");
  high_pass(field, options.high_pass_sigma_px);

  // A ramp at either end; the copy one period away has its own ramp there.
  const auto alpha = [&](int i) {
    const float from_end = static_cast<float>(std::min(i, side - 1 - i)) + 0.5f;
    return std::min(from_end / static_cast<float>(options.feather_px), 1.0f);
  };
  NoisePatch patch(period, period, 3);
  for (int y = 0; y < period; ++y) {
    for (int x = 0; x < period; ++x) {
      float squares = 0;
      for (int v = y; v < side; v += period) {
        for (int u = x; u < side; u += period) {
          const float weight = alpha(u) * alpha(v);
          squares += weight * weight;
          for (int c = 0; c < 3; ++c) patch.at(x, y, c) += weight * field.at(u, v, c);
        }
      }
      const float patches = static_cast<float>(options.periods_px.size());
      for (int c = 0; c < 3; ++c) patch.at(x, y, c) /= std::sqrt(squares * patches);
    }
  }
  return patch;
}

float tile_sign(int period, int column, int line) {
  const auto tile = static_cast<std::uint64_t>(column) << 32 | static_cast<std::uint64_t>(line);
  return random_bits(random_bits(static_cast<std::uint64_t>(period)) ^ tile) & 1 ? 1.0f : -1.0f;
}

}  // namespace

OptionFields fields(NoiseOptions& options) {
  OptionFields all;
  for (std::size_t i = 0; i < options.periods_px.size(); ++i) {
    all.push_back(
        {"periods_px." + std::to_string(i), &options.periods_px[i], 8, 4096, "px", "ours (5.3: relatively prime)"});
  }
  all.push_back({"feather_px", &options.feather_px, 1, 1000, "px", "ours"});
  all.push_back({"high_pass_sigma_px", &options.high_pass_sigma_px, 0.1, 1000, "px", "ours"});
  return all;
}

std::vector<NoisePatch> make_noise_patches(std::uint64_t seed, const NoiseOptions& options) {
  std::vector<NoisePatch> patches;
  for (const int period : options.periods_px) patches.push_back(make_patch(seed + patches.size(), period, options));
  return patches;
}

NoiseLevel merged_noise(const Exposure& exposure, int frames) {
  const double range = exposure.white_level_dn - exposure.black_level_dn;
  const double left = merged_mosaic_variance(frames);
  return {left * exposure.mosaic_noise.shot_dn / range, left * exposure.mosaic_noise.read_dn2 / (range * range),
          exposure.white_balance, exposure.color_matrix.value_or(kIdentity3)};
}

void add_noise(Image& rgb, const Image& blurred, const std::vector<NoisePatch>& patches, const NoiseLevel& level,
               const Image& shading_gain) {
  const int width = rgb.width;
  std::array<float, 9> to_srgb{}, to_camera{};
  const Matrix3 camera_from_srgb = inverse(level.color_matrix);
  std::copy(level.color_matrix.begin(), level.color_matrix.end(), to_srgb.begin());
  std::copy(camera_from_srgb.begin(), camera_from_srgb.end(), to_camera.begin());
  std::array<float, 3> shot{}, read{};
  for (int k = 0; k < 3; ++k) {
    shot[k] = static_cast<float>(level.gains[k] * level.shot);
    read[k] = static_cast<float>(level.gains[k] * level.gains[k] * level.read);
  }
  tbb::parallel_for(tbb::blocked_range<int>(0, rgb.height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> noise(static_cast<std::size_t>(width) * 3);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      std::fill(noise.begin(), noise.end(), 0.0f);
      for (const NoisePatch& patch : patches) {
        const float* from = patch.row(y % patch.height);
        for (int x0 = 0; x0 < width; x0 += patch.width) {
          const int values = 3 * std::min(patch.width, width - x0);
          const float sign = tile_sign(patch.width, x0 / patch.width, y / patch.height);
          for (int i = 0; i < values; ++i) noise[3 * x0 + i] += sign * from[i];
        }
      }
      const float* amount = blurred.row(y);
      float* row = rgb.row(y);
      for (int x = 0; x < width; ++x) {
        float* rgb_here = row + 3 * x;
        const float gain = shading_gain.empty() ? 1.0f : shading_gain.at(x, y);
        std::array<float, 3> camera_noise{};
        for (int k = 0; k < 3; ++k) {
          float value = 0;
          for (int c = 0; c < 3; ++c) value += to_camera[3 * k + c] * rgb_here[c];
          const float variance = gain * (shot[k] * std::max(value, 0.0f) + gain * read[k]);
          camera_noise[k] = std::sqrt(variance) * amount[x] * noise[3 * x + k];
        }
        for (int c = 0; c < 3; ++c) {
          for (int k = 0; k < 3; ++k) rgb_here[c] += to_srgb[3 * c + k] * camera_noise[k];
        }
      }
    }
  });
}

}  // namespace dualpixel::pipeline
