#include "pipeline/burst/fft16.h"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>
#include <random>

namespace dualpixel::pipeline::fft16 {
namespace {

std::complex<double> sample(const ComplexTile& tile, int row, int column) {
  return {tile.re[row][column / kLanes][column % kLanes], tile.im[row][column / kLanes][column % kLanes]};
}

TEST(Fft16, IsTheSumThatItStandsFor) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  ComplexTile tile;
  for (int y = 0; y < kTile; ++y) {
    for (int x = 0; x < kTile; ++x) {
      tile.re[y][x / kLanes][x % kLanes] = normal(random);
      tile.im[y][x / kLanes][x % kLanes] = normal(random);
    }
  }
  Phases along_x, along_y;
  for (int k = 0; k < kTile; ++k) {
    along_x.re[k] = normal(random);
    along_x.im[k] = normal(random);
    along_y.re[k] = normal(random);
    along_y.im[k] = normal(random);
  }
  ComplexTile plain = tile, turned = tile;
  transform(plain);
  transform(turned, along_x, along_y);
  for (int kx = 0; kx < kTile; ++kx) {
    for (int ky = 0; ky < kTile; ++ky) {
      std::complex<double> sum;
      for (int y = 0; y < kTile; ++y) {
        for (int x = 0; x < kTile; ++x) {
          sum += sample(tile, y, x) * std::polar(1.0, -2 * std::numbers::pi / kTile * (kx * x + ky * y));
        }
      }
      EXPECT_LT(std::abs(sample(plain, kx, ky) - sum), 5e-5);
      sum *=
          std::complex<double>(along_x.re[kx], along_x.im[kx]) * std::complex<double>(along_y.re[ky], along_y.im[ky]);
      EXPECT_LT(std::abs(sample(turned, kx, ky) - sum), 5e-4);
    }
  }
  transform_back(plain);
  for (int y = 0; y < kTile; ++y) {
    for (int x = 0; x < kTile; ++x) EXPECT_LT(std::abs(sample(plain, y, x) / 256.0 - sample(tile, y, x)), 1e-6);
  }
}

}  // namespace
}  // namespace dualpixel::pipeline::fft16
