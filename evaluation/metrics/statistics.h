#pragma once
#include <algorithm>
#include <cmath>
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

inline double deviation(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) sum += value, squares += value * value;
  const auto n = static_cast<double>(values.size());
  return std::sqrt(std::max(squares / n - sum / n * (sum / n), 0.0));
}

}  // namespace dualpixel::evaluation
