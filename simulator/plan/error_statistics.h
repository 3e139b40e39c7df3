#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace dualpixel::simulator {

inline double square(double x) { return x * x; }

inline double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Root of the mean of squares plus three of that mean's standard errors.
inline double upper_rms(const std::vector<double>& squares) {
  const auto n = static_cast<double>(squares.size());
  const double mean_square = mean(squares);
  double scatter = 0;
  for (double value : squares) scatter += square(value - mean_square);
  return std::sqrt(std::max(mean_square, 0.0) + 3 * std::sqrt(scatter / (n * (n - 1))));
}

}  // namespace dualpixel::simulator
