#include "evaluation/metrics/image_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dualpixel::evaluation {
namespace {

Image random_image(int width, int height, int channels, unsigned seed) {
  std::mt19937 generator(seed);
  Image image(width, height, channels);
  for (float& value : image.data) value = static_cast<float>(generator()) / 4294967296.0f;
  return image;
}

TEST(Psnr, OfAKnownDifference) {
  const Image a(8, 4, 3, 0.5f), b(8, 4, 3, 0.6f);
  EXPECT_NEAR(*psnr_db(a, b), 20, 1e-5);  // mean square 0.01; 0.1 in float is off by 1e-7
  Image one_pixel = a;
  one_pixel.at(3, 2, 1) = 1.0f;  // 0.25 / 96
  EXPECT_NEAR(*psnr_db(a, one_pixel), 10 * std::log10(96 / 0.25), 1e-9);
  EXPECT_FALSE(psnr_db(a, a));
}

TEST(Ssim, OfIdenticalPicturesIsOne) {
  const Image image = random_image(30, 20, 3, 1);
  EXPECT_NEAR(*ssim(image, image), 1, 1e-6);
}

TEST(Ssim, OfFlatPicturesComparesMeans) {
  const double expected = (2 * 0.3 * 0.6 + 1e-4) / (0.09 + 0.36 + 1e-4);
  EXPECT_NEAR(*ssim(Image(16, 16, 3, 0.3f), Image(16, 16, 3, 0.6f)), expected, 1e-4);
}

TEST(Ssim, AgreesWithItsDefinition) {
  const Image a = random_image(17, 14, 1, 2), b = random_image(17, 14, 1, 3);
  double weights[11][11], total = 0;
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 11; ++i) {
      weights[j][i] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
      total += weights[j][i];
    }
  }
  double sum = 0;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 7; ++x) {
      double mean_a = 0, mean_b = 0, variance_a = 0, variance_b = 0, covariance = 0;
      for (int j = 0; j < 11; ++j) {
        for (int i = 0; i < 11; ++i) {
          mean_a += weights[j][i] / total * a.at(x + i, y + j);
          mean_b += weights[j][i] / total * b.at(x + i, y + j);
        }
      }
      for (int j = 0; j < 11; ++j) {
        for (int i = 0; i < 11; ++i) {
          const double da = a.at(x + i, y + j) - mean_a, db = b.at(x + i, y + j) - mean_b;
          variance_a += weights[j][i] / total * da * da;
          variance_b += weights[j][i] / total * db * db;
          covariance += weights[j][i] / total * da * db;
        }
      }
      sum += (2 * mean_a * mean_b + 1e-4) * (2 * covariance + 9e-4) /
             ((mean_a * mean_a + mean_b * mean_b + 1e-4) * (variance_a + variance_b + 9e-4));
    }
  }
  EXPECT_NEAR(*ssim(a, b), sum / 28, 1e-5);  // float moments near 0.1, constants of 1e-3
}

TEST(Ssim, NeedsAWholeWindow) {
  EXPECT_FALSE(ssim(Image(10, 30, 1), Image(10, 30, 1)));
  EXPECT_TRUE(ssim(Image(11, 11, 1), Image(11, 11, 1)));
}

TEST(Encoding, ClipsAndDropsNaN) {
  Image image(4, 1);
  image.data = {-1, 0.25f, 7, NAN};
  EXPECT_EQ(clipped(image).data, (std::vector<float>{0, 0.25f, 1, 0}));
  const Image srgb = displayed(image, 2);
  EXPECT_NEAR(srgb.at(1, 0), 1.055 * std::pow(0.5, 1 / 2.4) - 0.055, 1e-6);
  EXPECT_EQ(srgb.at(0, 0), 0);
  EXPECT_FLOAT_EQ(srgb.at(2, 0), 1);
  EXPECT_EQ(srgb.at(3, 0), 0);
}

}  // namespace
}  // namespace dualpixel::evaluation
