#pragma once
#include <algorithm>
#include <vector>

namespace dualpixel::simulator {

/// A function of the distance from the axis: sum of c_i h^(2 i + 2).
struct EvenPolynomial {
  std::vector<double> c;
  double operator()(double h2) const {
    double sum = 0;
    for (auto i = c.rbegin(); i != c.rend(); ++i) sum = (sum + *i) * h2;
    return sum;
  }
};

/// A quantity over the sensor: constant + gradient . (x, y) + map, the map bilinear between the centers of its cells,
/// which cover the square |x|, |y| <= 1 row by row from the top left.
struct FieldMap {
  double constant = 0;
  double gradient_x = 0, gradient_y = 0;
  int columns = 0, rows = 0;
  std::vector<float> cells{};

  double operator()(double x, double y) const {
    double value = constant + gradient_x * x + gradient_y * y;
    if (!cells.empty()) {
      const double u = std::clamp(0.5 * (x + 1) * columns - 0.5, 0.0, columns - 1.0);
      const double v = std::clamp(0.5 * (y + 1) * rows - 0.5, 0.0, rows - 1.0);
      const int i = std::min(static_cast<int>(u), std::max(columns - 2, 0));
      const int j = std::min(static_cast<int>(v), std::max(rows - 2, 0));
      const int right = std::min(i + 1, columns - 1), below = std::min(j + 1, rows - 1);
      const double a = u - i, b = v - j;
      value += (1 - b) * ((1 - a) * cells[j * columns + i] + a * cells[j * columns + right]) +
               b * ((1 - a) * cells[below * columns + i] + a * cells[below * columns + right]);
    }
    return value;
  }
};

}  // namespace dualpixel::simulator
