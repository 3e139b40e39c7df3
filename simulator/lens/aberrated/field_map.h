#pragma once
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

  double operator()(double x, double y) const;
};

}  // namespace dualpixel::simulator
