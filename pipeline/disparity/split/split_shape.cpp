#include "pipeline/disparity/split/split_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dualpixel::pipeline::split {
namespace {

/// alpha of the share g(p) = p / k between -1 and 1, k from 0 to 1: (2 / pi) times the integral of p g(p) sqrt(1 -
/// p^2).
double alpha_of(double k) {
  const double rim = std::sqrt(1 - k * k);
  const double ramp = k > 0 ? (std::asin(k) - k * rim * (1 - 2 * k * k)) / (8 * k) : 0;
  return 4 / std::numbers::pi * (ramp + rim * rim * rim / 3);
}

}  // namespace

double ramp_width(double alpha) {
  if (alpha <= 0.25) return 1 / (4 * alpha);
  double low = 0, high = 1;  // alpha falls with k
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (low + high);
    (alpha_of(middle) > alpha ? low : high) = middle;
  }
  return low;
}

ShapeSkew skew_at(double alpha, double frequency) {
  constexpr int kChords = 512;
  const double k = ramp_width(alpha);
  // Means over the disc, by Gauss's quadrature for a weight of sqrt(1 - p^2); both sides are alike.
  double centroid = 0, disc = 0, moment = 0, slope = 0;  // of g: along x its transform; across, the transform's slope
  for (int i = 1; i <= kChords; ++i) {
    const double angle = std::numbers::pi * i / (2 * kChords + 1), p = std::cos(angle), half_chord = std::sin(angle);
    const double weight = 4.0 / (2 * kChords + 1) * half_chord * half_chord, g = std::min(p / k, 1.0);
    const double across = frequency * half_chord;
    centroid += weight * p * g;
    disc += weight * std::cos(frequency * p);
    moment += weight * g * std::sin(frequency * p);
    slope += weight * p * g * std::sin(across) / across;
  }
  const double phase = 2 * std::atan(moment / disc), shift = 2 * slope / disc;
  return {-3 * (phase - 2 * centroid * frequency) / std::pow(frequency, 3),
          -(shift - 2 * centroid) / (frequency * frequency)};
}

}  // namespace dualpixel::pipeline::split
