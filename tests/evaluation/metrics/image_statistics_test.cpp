// Statistics of pictures: a known spectrum and known gradients are found under noise.
#include "evaluation/metrics/image_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace dualpixel::evaluation {
namespace {

constexpr int kSide = 128;

NoisyPictures with_noise(const Image& picture, float deviation) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0, deviation);
  NoisyPictures pictures;
  for (Image& one : pictures) {
    one = picture;
    for (float& value : one.data) value += noise(random);
  }
  return pictures;
}

/// Waves of all frequencies up to 40 cycles, random in phase, amplitude f^slope.
Image waves(double slope, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
  std::vector<double> cosine(kSide);
  for (int i = 0; i < kSide; ++i) cosine[i] = std::cos(2 * std::numbers::pi * i / kSide);
  Image picture(kSide, kSide);
  for (int ky = 0; ky <= 40; ++ky) {
    for (int kx = -40; kx <= 40; ++kx) {
      const double f = std::hypot(kx, ky);
      if (f < 1 || f > 40) continue;
      const auto amplitude = static_cast<float>(std::pow(f, slope));
      const int shift = static_cast<int>(phase(random) / (2 * std::numbers::pi) * kSide);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x)
          picture.at(x, y) +=
              amplitude * static_cast<float>(cosine[((kx * x + ky * y + shift) % kSide + kSide) % kSide]);
      }
    }
  }
  return picture;
}

/// Standard error of the fitted slope: a ring of radius f holds pi f independent waves, of which Hann's window leaves a
/// fourth, and their power is exponentially distributed.
double slope_error() {
  double sw = 0, sx = 0, sxx = 0, variance = 0;
  for (int f = 4; f <= kSide / 4; ++f) sw += 1.0 / f, sx += std::log(f) / f, sxx += std::log(f) * std::log(f) / f;
  for (int f = 4; f <= kSide / 4; ++f)
    variance += std::pow((std::log(f) - sx / sw) / f, 2) * 0.25 / (std::numbers::pi * f / 4);
  return std::sqrt(variance) / (sxx - sx * sx / sw);
}

TEST(SlowImageStatistics, FindTheSlopeOfASpectrumUnderNoise) {
  constexpr int kPictures = 4;
  for (const double slope : {-1.0, -1.4}) {
    double clean = 0, noisy = 0;
    for (unsigned seed = 1; seed <= kPictures; ++seed) {
      const Image picture = waves(slope, seed);
      clean += amplitude_slope(with_noise(picture, 0)) / kPictures;
      // white noise as strong as the picture at 13 cycles: a plain spectrum would be flatter by .3
      const double strength = kSide * std::pow(13, slope) / 2;
      noisy += amplitude_slope(with_noise(picture, static_cast<float>(strength))) / kPictures;
    }
    EXPECT_NEAR(clean, slope, 3 * slope_error() / std::sqrt(kPictures));
    EXPECT_NEAR(noisy, slope, 4 * slope_error() / std::sqrt(kPictures));
  }
}

TEST(ImageStatistics, GradientsHoldNoNoise) {
  std::mt19937 random(5);
  std::bernoulli_distribution rare(0.04);
  Image picture(512, 384);
  for (float& value : picture.data) value = rare(random) ? 1.0f : 0.0f;
  // differences of two independent Bernoulli numbers: variance 2 p q, fourth moment 2 p q
  const double pq = 0.04 * 0.96, n = 2.0 * 512 * 384;
  const GradientMoments found = gradient_moments(with_noise(picture, 0.2f));
  // their own spread, and that of the means of products: 1/sqrt(n) each, neighbors shared
  EXPECT_NEAR(found.square, 2 * pq, 4 * 2 * std::sqrt(2 * pq / n));
  EXPECT_NEAR(found.kurtosis(), 1 / (2 * pq), 4 * 2 * std::sqrt(1 / (2 * pq * n)) / (2 * pq));
}

TEST(ImageStatistics, QuantilesOfNothingAreZero) {
  EXPECT_EQ(quantiles({})[2], 0);
  EXPECT_EQ(quantiles({3, 1, 2})[2], 2);
}

}  // namespace
}  // namespace dualpixel::evaluation
