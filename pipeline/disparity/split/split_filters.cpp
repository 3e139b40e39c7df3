#include "pipeline/disparity/split/split_filters.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "pipeline/disparity/split/split_shape.h"

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

/// Taps that stand for one along an axis: each beside the middle for two.
double count(int i) { return i == 0 ? 1 : 2; }

/// Sum of the squares of all taps, of the four quadrants.
double energy(const Quadrant& filter) {
  double sum = 0;
  for (int y = 0; y < filter.side; ++y) {
    for (int x = 0; x < filter.side; ++x) sum += count(x) * count(y) * filter.at(x, y) * filter.at(x, y);
  }
  return sum;
}

/// The best product of a filter along x and one along y, by power iteration; taken out of `filter`.
SeparableFilter take_term(Quadrant& filter) {
  constexpr int kIterations = 12;
  const int side = filter.side;
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

/// The transform of g D, odd along x, for frequencies that `radius` and `radius_y` turn into phases at the disc's rim,
/// by Gauss's quadrature over chords.
class SplitMoment {
 public:
  SplitMoment(double k, double phase_step_x, double phase_step_y, int steps) {
    const int nodes = 2 * static_cast<int>(std::ceil(std::max(phase_step_x, phase_step_y) * steps)) + 64;
    for (int i = 1; 2 * i <= nodes; ++i) {  // the other half is alike
      const double angle = std::numbers::pi * i / (nodes + 1), x = std::cos(angle), half_chord = std::sin(angle);
      const double weight = 4.0 / (nodes + 1) * half_chord * half_chord * std::min(x / k, 1.0);
      for (int u = 0; u <= steps; ++u) along_x_.push_back(weight * std::sin(phase_step_x * u * x));
      for (int v = 0; v <= steps; ++v) {
        const double phase = phase_step_y * v * half_chord;
        along_y_.push_back(phase > 1e-6 ? std::sin(phase) / phase : 1.0);
      }
    }
    size_ = steps + 1;
  }

  double operator()(int u, int v) const {
    double sum = 0;
    for (std::size_t i = 0; i < along_x_.size(); i += size_) sum += along_x_[i + u] * along_y_[i + v];
    return sum;
  }

 private:
  std::size_t size_;
  std::vector<double> along_x_, along_y_;  ///< node after node
};

}  // namespace

SplitFilters make_filters(double d_dp_px, double alpha, const FilterGrid& grid) {
  constexpr double kLeastResponse = 0.1;  // frequencies that the blur leaves less of count for less
  constexpr double kLeftOut = 2e-4;       // by separable terms, of the energy,
  constexpr std::size_t kMostTerms = 4;   // where so many do
  const double smoothing = grid.smoothing;
  const double radius = d_dp_px / alpha / grid.sample_px / 2, radius_y = radius / grid.height;
  const auto taps = [&](double r) { return static_cast<std::size_t>(std::ceil(r + 6 * smoothing)) + 1; };
  const int reach = static_cast<int>(std::max(taps(radius), taps(radius_y))) - 1;
  const int half = reach + 8;                   // of the period
  const double step = std::numbers::pi / half;  // radians a sample
  const SplitMoment moment(ramp_width(alpha), step * radius, step * radius_y, half);
  Quadrant even(half + 1), odd(half + 1);
  for (int v = 0; v <= half; ++v) {
    for (int u = 0; u <= half; ++u) {
      const double along_x = step * u, along_y = step * v;
      const double z = std::hypot(along_x * radius, along_y * radius_y);
      const double gauss = std::exp(-0.5 * std::pow(std::hypot(along_x, along_y) * smoothing, 2));
      if (gauss < 1e-6) continue;
      const double disc = z > 1e-6 ? 2 * std::cyl_bessel_j(1.0, z) / z : 1.0;
      const double moment_there = moment(u, v);
      const double scale =
          gauss / std::sqrt(disc * disc + moment_there * moment_there + kLeastResponse * kLeastResponse);
      even.at(u, v) = disc * scale;
      odd.at(u, v) = u < half ? moment_there * scale : 0.0;
    }
  }
  Quadrant difference = transformed(even, 2 * half, false, reach + 1);
  Quadrant sum = transformed(odd, 2 * half, true, reach + 1);
  const double negligible = kLeftOut * (energy(difference) + energy(sum));
  SplitFilters filters{reach, {}, {}};
  for (auto [filter, terms] : {std::pair{&difference, &filters.difference}, {&sum, &filters.sum}}) {
    while (energy(*filter) > negligible && terms->size() < kMostTerms) {
      SeparableFilter term = take_term(*filter);
      term.along_x.resize(taps(radius)), term.along_y.resize(taps(radius_y));
      terms->push_back(std::move(term));
    }
  }
  return filters;
}

}  // namespace dualpixel::pipeline::split
