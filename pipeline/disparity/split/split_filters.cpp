#include "pipeline/disparity/split/split_filters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dualpixel::pipeline::split {
namespace {

/// A filter's quadrant x, y >= 0.
struct Quadrant {
  int side = 0;
  std::vector<double> data;

  explicit Quadrant(int side_) : side(side_), data(static_cast<std::size_t>(side_) * side_) {}
  double& at(int x, int y) { return data[static_cast<std::size_t>(y) * side + x]; }
  double at(int x, int y) const { return data[static_cast<std::size_t>(y) * side + x]; }
};

/// The inverse Fourier transform, `period` samples along each axis, of a spectrum that is even along y and even or
/// (`odd`) odd along x.
Quadrant transformed(const Quadrant& spectrum, int period, bool odd, int side) {
  const double unit = 2 * std::numbers::pi / period;
  const int last = spectrum.side - 1;  // half the period
  const auto weight = [&](int u) { return (u == 0 || u == last ? 1.0 : 2.0) / period; };
  std::vector<double> rows(static_cast<std::size_t>(spectrum.side) * side);  // frequency along y, position along x
  for (int v = 0; v <= last; ++v) {
    for (int x = 0; x < side; ++x) {
      double sum = 0;
      for (int u = 0; u <= last; ++u) {
        sum += weight(u) * spectrum.at(u, v) * (odd ? std::sin(unit * u * x) : std::cos(unit * u * x));
      }
      rows[static_cast<std::size_t>(v) * side + x] = sum;
    }
  }
  Quadrant out(side);
  for (int y = 0; y < side; ++y) {
    for (int v = 0; v <= last; ++v) {
      const double factor = weight(v) * std::cos(unit * v * y);
      for (int x = 0; x < side; ++x) out.at(x, y) += factor * rows[static_cast<std::size_t>(v) * side + x];
    }
  }
  return out;
}

/// The best product of a filter along x and one along y, by power iteration; taken out of `filter`.
SeparableFilter take_term(Quadrant& filter) {
  constexpr int kIterations = 12;
  const int side = filter.side;
  const auto count = [](int i) { return i == 0 ? 1.0 : 2.0; };  // a tap beside the middle stands for two
  std::vector<double> x(side, 1.0), y(side, 0.0);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    double norm = 1e-300;
    for (int i = 0; i < side; ++i) norm += count(i) * x[i] * x[i];
    for (int j = 0; j < side; ++j) {
      y[j] = 0;
      for (int i = 0; i < side; ++i) y[j] += count(i) * filter.at(i, j) * x[i] / norm;
    }
    norm = 1e-300;
    for (int j = 0; j < side; ++j) norm += count(j) * y[j] * y[j];
    for (int i = 0; i < side; ++i) {
      x[i] = 0;
      for (int j = 0; j < side; ++j) x[i] += count(j) * filter.at(i, j) * y[j] / norm;
    }
  }
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) filter.at(i, j) -= x[i] * y[j];
  }
  return {{x.begin(), x.end()}, {y.begin(), y.end()}};
}

}  // namespace

SplitFilters make_filters(double d_dp_px, double alpha, double sample_px, double smoothing) {
  constexpr double kLeastResponse = 0.05;  // frequencies that the blur leaves less of count for less
  const double radius = d_dp_px / alpha / sample_px / 2;
  const double k = 1 / (4 * alpha);
  const int reach = static_cast<int>(std::ceil(radius + 6 * smoothing));
  const int half = reach + 8;  // of the period
  Quadrant even(half + 1), odd(half + 1);
  for (int v = 0; v <= half; ++v) {
    for (int u = 0; u <= half; ++u) {
      const double f = std::hypot(u, v) / (2 * half);
      const double z = 2 * std::numbers::pi * f * radius;
      const double gauss = std::exp(-0.5 * std::pow(2 * std::numbers::pi * f * smoothing, 2));
      if (gauss < 1e-6) continue;
      const double disc = z > 1e-6 ? 2 * std::cyl_bessel_j(1.0, z) / z : 1.0;
      const double moment = z > 1e-6 ? 2 * std::cyl_bessel_j(2.0, z) / z * (u / std::hypot(u, v)) / k : 0.0;
      const double scale = gauss / std::sqrt(disc * disc + moment * moment + kLeastResponse * kLeastResponse);
      even.at(u, v) = disc * scale;
      odd.at(u, v) = u < half ? moment * scale : 0.0;
    }
  }
  Quadrant difference = transformed(even, 2 * half, false, reach + 1);
  Quadrant sum = transformed(odd, 2 * half, true, reach + 1);
  SplitFilters filters{reach, {}, {}};
  for (int term = 0; term < SplitFilters::kTerms; ++term) {
    filters.difference[term] = take_term(difference);
    filters.sum[term] = take_term(sum);
  }
  return filters;
}

}  // namespace dualpixel::pipeline::split
