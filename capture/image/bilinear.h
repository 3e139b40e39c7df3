#pragma once
#include <algorithm>

namespace dualpixel {

/// Where a position lies between two of `size` evenly spaced nodes; beyond the outer ones it is at them.
struct BilinearTap {
  int low = 0, high = 0;
  double share_of_high = 0;
};
inline BilinearTap bilinear_tap(double at, int size) {
  const double inside = std::clamp(at, 0.0, size - 1.0);
  const int low = std::max(std::min(static_cast<int>(inside), size - 2), 0);
  return {low, std::min(low + 1, size - 1), inside - low};
}

/// Between four nodes of a grid, whose values `node(column, row)` gives.
template <class Node>
double bilinear(const BilinearTap& x, const BilinearTap& y, const Node& node) {
  const double a = x.share_of_high, b = y.share_of_high;
  return (1 - b) * ((1 - a) * node(x.low, y.low) + a * node(x.high, y.low)) +
         b * ((1 - a) * node(x.low, y.high) + a * node(x.high, y.high));
}

}  // namespace dualpixel
