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

SplitFilters make_filters(double d_dp_px, double alpha, const FilterGrid& grid) {
  constexpr double kLeastResponse = 0.05;  // frequencies that the blur leaves less of count for less
  const double smoothing = grid.smoothing;
  const double radius = d_dp_px / alpha / grid.sample_px / 2, radius_y = radius / grid.height;
  const double k = 1 / (4 * alpha);
  const auto taps = [&](double r) { return static_cast<std::size_t>(std::ceil(r + 6 * smoothing)) + 1; };
  const int reach = static_cast<int>(std::max(taps(radius), taps(radius_y))) - 1;
  const int half = reach + 8;  // of the period
  Quadrant even(half + 1), odd(half + 1);
  for (int v = 0; v <= half; ++v) {
    for (int u = 0; u <= half; ++u) {
      const double along_x = std::numbers::pi * u / half, along_y = std::numbers::pi * v / half;  // radians a sample
      const double z = std::hypot(along_x * radius, along_y * radius_y);
      const double gauss = std::exp(-0.5 * std::pow(std::hypot(along_x, along_y) * smoothing, 2));
      if (gauss < 1e-6) continue;
      const double disc = z > 1e-6 ? 2 * std::cyl_bessel_j(1.0, z) / z : 1.0;
      const double moment = z > 1e-6 ? 2 * std::cyl_bessel_j(2.0, z) / z * (along_x * radius / z) / k : 0.0;
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
    for (SeparableFilter* filter : {&filters.difference[term], &filters.sum[term]}) {
      filter->along_x.resize(taps(radius)), filter->along_y.resize(taps(radius_y));
    }
  }
  return filters;
}

}  // namespace dualpixel::pipeline::split
