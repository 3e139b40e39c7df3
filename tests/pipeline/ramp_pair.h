#pragma once
#include <cmath>
#include <numbers>
#include <random>

#include "capture/image/image.h"

/// Views of a plane through a soft split, in closed form.
namespace dualpixel::pipeline {

inline constexpr int kRampWidth = 512, kRampHeight = 256;
inline constexpr double kRampAlpha = 0.21;                          // the matcher's default
inline constexpr double kHalvesAlpha = 4 / (3 * std::numbers::pi);  // of a hard split

/// The transform at (fx, fy) of a disc of diameter |b| with weights 1 + side x / (k radius), k = 1 / (4 alpha), or,
/// with kHalvesAlpha, of either half of it, by sums over chords: its even part, and the part that comes with sin.
struct Response {
  double even = 0, odd = 0;
};

inline Response ramp_response(double fx, double fy, double b, double alpha) {
  constexpr int kSteps = 200;
  const double radius = std::abs(b) / 2, tilt = (b > 0 ? 4 : -4) * alpha;
  const bool hard = alpha == kHalvesAlpha;
  Response sum;
  double total = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps * 2 - 1, half = std::sqrt(1 - x * x);
    const double across = 2 * std::numbers::pi * fy * radius * half;
    const double chord = half * (std::abs(across) > 1e-9 ? std::sin(across) / across : 1.0);
    const double along = 2 * std::numbers::pi * fx * radius * x;
    sum.even += chord * std::cos(along);
    sum.odd += chord * (hard ? (b > 0 ? 1 : -1) * (x > 0 ? 1 : -1) : tilt * x) * std::sin(along);
    total += half;
  }
  return {sum.even / total, sum.odd / total};
}

struct RampPair {
  Image left, right;
  double disparity = 0;
};

/// A plane at blur diameter b: cosines of random direction, amplitude 1 / f from 1/200 to 1/5 cycles a pixel, through
/// the closed form of a soft split; then noise of standard deviation `noise`. Mean 0.3. Blur is of the pixels' widths.
inline RampPair ramp_pair(unsigned seed, double b, double noise, double alpha = kRampAlpha, double pixel_height = 1,
                          int width = kRampWidth, int height = kRampHeight) {
  constexpr int kWaves = 150;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  RampPair pair{Image(width, height, 1, 0.3f), Image(width, height, 1, 0.3f), alpha * b};
  for (int wave = 0; wave < kWaves; ++wave) {
    const double f = 0.005 * std::pow(40, uniform(random)), angle = 2 * std::numbers::pi * uniform(random);
    const double fx = f * std::cos(angle), fy = f * std::sin(angle), phase = 2 * std::numbers::pi * uniform(random);
    const Response response = ramp_response(fx, fy / pixel_height, b, alpha);
    const double amplitude = 0.1 * std::sqrt(2.0 / kWaves) * std::hypot(response.even, response.odd);
    const double turn = std::atan2(response.odd, response.even);  // even cos t + odd sin t
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double t = 2 * std::numbers::pi * (fx * x + fy * y) + phase;
        pair.left.at(x, y) += static_cast<float>(amplitude * std::cos(t + turn));
        pair.right.at(x, y) += static_cast<float>(amplitude * std::cos(t - turn));
      }
    }
  }
  std::normal_distribution<float> normal(0, 1);
  for (Image* view : {&pair.left, &pair.right}) {
    for (float& value : view->data) value += static_cast<float>(noise) * normal(random);
  }
  return pair;
}

}  // namespace dualpixel::pipeline
