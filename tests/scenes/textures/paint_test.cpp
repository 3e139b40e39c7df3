// Textures by code: the noise has the spectrum that it says, and print shows its letters.
#include "scenes/textures/paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "capture/image/image_io.h"
#include "scenes/textures/lettering.h"

namespace dualpixel::scenes {
namespace {

/// Power of `rows` pictures of n x n texels in rings of frequency, by plain Fourier sums along rows, then columns.
std::vector<double> ring_power(const std::vector<double>& picture, int n) {
  using Complex = std::complex<double>;
  std::vector<Complex> root(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) root[i] = std::polar(1.0, -2 * std::numbers::pi * i / n);
  std::vector<Complex> rows(picture.size()), both(picture.size());
  for (int y = 0; y < n; ++y) {
    for (int k = 0; k < n; ++k) {
      for (int x = 0; x < n; ++x) rows[y * n + k] += picture[y * n + x] * root[k * x % n];
    }
  }
  for (int k = 0; k < n; ++k) {
    for (int m = 0; m < n; ++m) {
      for (int y = 0; y < n; ++y) both[m * n + k] += rows[y * n + k] * root[m * y % n];
    }
  }
  std::vector<double> power(static_cast<std::size_t>(n) / 2, 0.0), count(power.size(), 0.0);
  for (int m = 0; m < n; ++m) {
    for (int k = 0; k < n; ++k) {
      const double f = std::hypot(m > n / 2 ? m - n : m, k > n / 2 ? k - n : k);
      const auto ring = static_cast<std::size_t>(std::lround(f));
      if (ring >= power.size()) continue;
      power[ring] += std::norm(both[m * n + k]);
      ++count[ring];
    }
  }
  for (std::size_t i = 0; i < power.size(); ++i) power[i] /= std::max(count[i], 1.0);
  return power;
}

/// Of log amplitude over log frequency, every octave the same weight.
double measured_slope(float slope) {
  constexpr int kSize = 128, kPictures = 8, kFrom = 4, kTo = 24;
  std::vector<double> power(kSize / 2, 0.0);
  for (std::uint32_t seed = 1; seed <= kPictures; ++seed) {
    const PinkNoise noise(100 * seed, 2, 64, slope);
    std::vector<double> picture;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) picture.push_back(noise((x + 0.5f) / kSize, (y + 0.5f) / kSize));
    }
    const std::vector<double> one = ring_power(picture, kSize);
    for (std::size_t i = 0; i < power.size(); ++i) power[i] += one[i];
  }
  double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int f = kFrom; f <= kTo; ++f) {
    const double w = 1.0 / f, x = std::log(f), y = 0.5 * std::log(power[f]);
    sw += w, sx += w * x, sy += w * y, sxx += w * x * x, sxy += w * x * y;
  }
  return -(sw * sxy - sx * sy) / (sw * sxx - sx * sx);
}

// Octaves of value noise approximate a power law with ripples of one octave; over two and a half octaves they tilt the
// fit by up to 0.15. Sampling error of 8 pictures: below 0.03.
TEST(PinkNoise, HasTheSlopeThatItSays) {
  for (const float slope : {1.0f, 1.3f, 1.6f}) EXPECT_NEAR(measured_slope(slope), slope, 0.18) << slope;
}

TEST(PinkNoise, HasMeanZeroAndDeviationOne) {
  double sum = 0, squares = 0;
  constexpr int kSize = 128, kPictures = 16;
  for (std::uint32_t seed = 1; seed <= kPictures; ++seed) {
    const PinkNoise noise(1000 * seed, 8, 64, 1.2f);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double n = noise((x + 0.5f) / kSize, (y + 0.5f) / kSize);
        sum += n, squares += n * n;
      }
    }
  }
  const double count = 1.0 * kSize * kSize * kPictures, mean = sum / count;
  // the lowest octave has 64 cells a picture, each of deviation .289 / .2145: 1.35 / sqrt(64 * 16) = .042, three times
  EXPECT_NEAR(mean, 0, 0.13);
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 1, 0.04);
}

// Of three million values, a hundred or more between any two bytes; below 0, above 1 and NaN as the curve has them.
TEST(Paint, HasTheBytesOfTheSrgbCurve) {
  constexpr int kSize = 1024;  // so that texels' middles are exact
  std::vector<float> values(3 * kSize * kSize);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = 1.02f * static_cast<float>(i) / static_cast<float>(values.size()) - 0.01f;
  }
  values[0] = NAN, values[1] = -INFINITY, values[2] = INFINITY;
  const Texture texture = paint(kSize, [&](float u, float v) {
    const auto x = static_cast<std::size_t>(u * kSize), y = static_cast<std::size_t>(v * kSize);
    const float* rgb = &values[3 * (y * kSize + x)];
    return glm::vec3(rgb[0], rgb[1], rgb[2]);
  });
  int wrong = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    wrong += texture.rgb[i] != std::lround(255 * srgb_from_linear(values[i]));
  EXPECT_EQ(wrong, 0);
}

TEST(PinkNoise, RepeatsSeamlessly) {
  const PinkNoise noise(5, 2, 32, 1.2f);
  for (const float v : {0.1f, 0.37f, 0.9f}) {
    EXPECT_NEAR(noise(1e-6f, v), noise(1 - 1e-6f, v), 1e-3);
    EXPECT_NEAR(noise(v, 1e-6f), noise(v, 1 - 1e-6f), 1e-3);
    EXPECT_FLOAT_EQ(noise(0.25f, v), noise(1.25f, v));
  }
}

TEST(Paint, RowsRunFromTheTop) {
  const Texture texture = paint(4, [](float u, float v) { return glm::vec3(u < 0.5f ? 1 : 0, v < 0.25f ? 1 : 0, 0); });
  EXPECT_EQ(texture.rgb[0], 255);
  EXPECT_EQ(texture.rgb[1], 255);
  EXPECT_EQ(texture.rgb[3 * 3], 0);
  EXPECT_EQ(texture.rgb[3 * 4 + 1], 0);
}

TEST(Lettering, LettersAndDigitsDiffer) {
  const std::string all = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
  std::vector<std::vector<bool>> shapes;
  for (const char letter : all) {
    std::vector<bool> shape;
    int inked = 0;
    for (int i = 0; i < 400; ++i) {
      const int column = i % 20, row = i / 20;
      shape.push_back(
          ink_at(std::string(1, letter), 0.8f * static_cast<float>(column) / 20, static_cast<float>(row) / 20) > 0.5f);
      inked += shape.back() ? 1 : 0;
    }
    EXPECT_GT(inked, 30) << letter;
    EXPECT_LT(inked, 240) << letter;
    for (const auto& other : shapes) {
      EXPECT_TRUE(letter == '0' || other != shape) << letter;  // O and 0 look alike
    }
    shapes.push_back(shape);
  }
  EXPECT_EQ(ink_at("A A", 1.2f, 0.5f), 0) << "a space has no ink";
}

}  // namespace
}  // namespace dualpixel::scenes
