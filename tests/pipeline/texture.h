#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// A texture known between its pixels: a sum of cosines of random direction and phase, mean 0, variance 1/2, with no
/// frequency above `highest` cycles a pixel.
class Texture {
 public:
  Texture(unsigned seed, double highest, int waves = 40) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < waves; ++i) {
      const double frequency = highest * std::sqrt(uniform(random));  // evenly spread over the disc of frequencies
      const double angle = 2 * std::numbers::pi * uniform(random);
      waves_.push_back({2 * std::numbers::pi * frequency * std::cos(angle),
                        2 * std::numbers::pi * frequency * std::sin(angle), 2 * std::numbers::pi * uniform(random)});
    }
  }

  /// The texture at (x0 + i * step_x, y0 + j * step_y) for pixel (i, j).
  Image raster(int width, int height, double x0, double step_x, double y0, double step_y) const {
    std::vector<double> sums(static_cast<std::size_t>(width) * height);
    std::vector<double> cos_x(width), sin_x(width);
    for (const Wave& wave : waves_) {  // cos(a + b) = cos a cos b - sin a sin b
      for (int i = 0; i < width; ++i) {
        cos_x[i] = std::cos(wave.x * (x0 + i * step_x));
        sin_x[i] = std::sin(wave.x * (x0 + i * step_x));
      }
      for (int j = 0; j < height; ++j) {
        const double b = wave.y * (y0 + j * step_y) + wave.phase;
        const double cos_y = std::cos(b), sin_y = std::sin(b);
        double* row = sums.data() + static_cast<std::size_t>(j) * width;
        for (int i = 0; i < width; ++i) row[i] += cos_x[i] * cos_y - sin_x[i] * sin_y;
      }
    }
    Image image(width, height);
    const double scale = 1 / std::sqrt(static_cast<double>(waves_.size()));
    for (std::size_t i = 0; i < sums.size(); ++i) image.data[i] = static_cast<float>(scale * sums[i]);
    return image;
  }

  /// Correlation of the texture with itself `shift` pixels further along x; 1 at 0.
  double correlation(double shift) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += std::cos(wave.x * shift);
    return sum / static_cast<double>(waves_.size());
  }

 private:
  struct Wave {
    double x, y, phase;
  };
  std::vector<Wave> waves_;
};

/// base + contrast * texture, shifted so that it shows texture(x - shift, y).
inline Image textured(const Texture& texture, int width, int height, double shift, double base = 0.5,
                      double contrast = 0.1) {
  Image image = texture.raster(width, height, 0.5 - shift, 1, 0.5, 1);
  for (float& value : image.data) value = static_cast<float>(base + contrast * value);
  return image;
}

inline void add_white_noise(Image& image, unsigned seed, double deviation) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, deviation);
  for (float& value : image.data) value += static_cast<float>(normal(random));
}

}  // namespace dualpixel::pipeline
