#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

namespace dualpixel::simulator {

inline double square(double x) { return x * x; }

/// Root of the mean of squares plus three of that mean's standard errors.
inline double upper_rms(const std::vector<double>& squares) {
  const auto n = static_cast<double>(squares.size());
  double sum = 0, sum2 = 0;
  for (double value : squares) sum += value;
  const double mean = sum / n;
  for (double value : squares) sum2 += square(value - mean);
  return std::sqrt(std::max(mean, 0.0) + 3 * std::sqrt(sum2 / (n * (n - 1))));
}

}  // namespace dualpixel::simulator
