#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace dualpixel::evaluation {

/// The middle value; of an even count the larger of the two in the middle. `values` must not be empty.
template <typename T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// 1.4826 times the median absolute deviation: the standard deviation of normally distributed values, outliers ignored.
inline double robust_deviation(std::vector<double> values) {
  const double center = median(values);
  for (double& value : values) value = std::abs(value - center);
  return 1.4826 * median(std::move(values));
}

/// 0 for one value. `values` must not be empty.
inline double deviation(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / n);
}

}  // namespace dualpixel::evaluation
