#include "pipeline/disparity/likelihood/interpolate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace dualpixel::pipeline {
namespace {

constexpr int kTaps = 8;
constexpr int kEntriesPerPx = 256;  // table entries a pixel; linear between them, which errs by less than 1e-4

using Weights = std::array<double, kTaps>;

/// Modified Bessel function of the first kind, order 0, by its power series.
double bessel_i0(double x) {
  double term = 1, sum = 1;
  for (int k = 1; k < 30; ++k) {
    term *= x * x / (4.0 * k * k);
    sum += term;
  }
  return sum;
}

Weights value_weights(double fraction) {
  // The low-pass ends below the views' highest frequency, as no interpolation over so few pixels is right near it: its
  // mirror image (alias) would pull shifts towards whole pixels.
  constexpr double kPassed = 0.84;  // of the highest frequency, at half height
  constexpr double kBeta = 4;       // of the Kaiser window, its pedestal taken off
  Weights weights;
  double sum = 0;
  for (int k = 0; k < kTaps; ++k) {
    const double t = fraction - (k - 3);
    const double inside = 1 - t * t / 16;
    const double window = inside > 0 ? bessel_i0(kBeta * std::sqrt(inside)) - 1 : 0;
    const double angle = std::numbers::pi * kPassed * t;
    weights[k] = window * (std::abs(t) < 1e-9 ? 1.0 : std::sin(angle) / angle);
    sum += weights[k];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// The third derivative of the polynomial through the eight pixels: within 2 % up to 0.15 cycles a pixel, 7 % at 0.2.
Weights third_weights(double fraction) {
  Eigen::Matrix<double, kTaps, kTaps> powers;
  for (int k = 0; k < kTaps; ++k) {
    for (int i = 0; i < kTaps; ++i) powers(k, i) = std::pow(k - 3 - fraction, i);
  }
  const Eigen::Matrix<double, kTaps, kTaps> coefficients = powers.inverse();
  Weights weights;
  for (int k = 0; k < kTaps; ++k) weights[k] = 6 * coefficients(3, k);
  return weights;
}

SincTaps make_taps(double fraction) {
  constexpr double kStep = 1e-4;
  const Weights value = value_weights(fraction);
  const Weights before = value_weights(fraction - kStep), after = value_weights(fraction + kStep);
  Weights slope;
  for (int k = 0; k < kTaps; ++k) slope[k] = (after[k] - before[k]) / (2 * kStep);

  const Weights third = third_weights(fraction);

  SincTaps taps;
  double value_value = 0, slope_slope = 0, slope_smooth = 0, smooth_smooth = 0;
  const auto slope_at = [&](int k) { return k >= 0 && k < kTaps ? slope[k] : 0.0; };
  for (int k = -1; k <= kTaps; ++k) {
    const double smooth = 0.25 * slope_at(k - 1) + 0.5 * slope_at(k) + 0.25 * slope_at(k + 1);
    smooth_smooth += 0.375 * smooth * smooth;  // three rows: 1/16 + 1/4 + 1/16
    if (k < 0 || k == kTaps) continue;
    taps.value[k] = static_cast<float>(value[k]);
    taps.slope[k] = static_cast<float>(slope[k]);
    taps.third[k] = static_cast<float>(third[k]);
    value_value += value[k] * value[k];
    slope_slope += slope[k] * slope[k];
    slope_smooth += 0.5 * slope[k] * smooth;
  }
  taps.value_value = static_cast<float>(value_value);
  taps.slope_slope = static_cast<float>(slope_slope);
  taps.slope_smooth = static_cast<float>(slope_smooth);
  taps.smooth_smooth = static_cast<float>(smooth_smooth);
  return taps;
}

}  // namespace

SincTaps sinc_taps(float fraction) {
  static const std::vector<SincTaps> table = [] {
    std::vector<SincTaps> entries;
    for (int i = 0; i <= kEntriesPerPx; ++i) entries.push_back(make_taps(static_cast<double>(i) / kEntriesPerPx));
    return entries;
  }();
  const float at = fraction * kEntriesPerPx;
  const int low = std::min(static_cast<int>(at), kEntriesPerPx - 1);
  const SincTaps& a = table[low];
  const SincTaps& b = table[low + 1];
  const auto mix = [t = at - static_cast<float>(low)](float x, float y) { return x + t * (y - x); };
  SincTaps taps;
  for (int k = 0; k < kTaps; ++k) {
    taps.value[k] = mix(a.value[k], b.value[k]);
    taps.slope[k] = mix(a.slope[k], b.slope[k]);
    taps.third[k] = mix(a.third[k], b.third[k]);
  }
  taps.value_value = mix(a.value_value, b.value_value);
  taps.slope_slope = mix(a.slope_slope, b.slope_slope);
  taps.slope_smooth = mix(a.slope_smooth, b.slope_smooth);
  taps.smooth_smooth = mix(a.smooth_smooth, b.smooth_smooth);
  return taps;
}

}  // namespace dualpixel::pipeline
