#include "pipeline/disparity/split/shading.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel::pipeline::split {
namespace {

/// Position along an axis, from -1 to 1.
double position(int i, int size) { return (2 * i + 1.0) / size - 1; }

/// q = c + x dx + y dy of least sum of (left - right - q (left + right) / 2)^2: to first order, what makes both equal.
Eigen::Vector3d fit_ratio(const Image& left, const Image& right) {
  constexpr double kRidge = 1e-6;  // of the sum of squares: a single row or column leaves a term open
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  for (int v = 0; v < left.height; ++v) {
    double weight = 0, weight_x = 0, weight_xx = 0, product = 0, product_x = 0;
    for (int u = 0; u < left.width; ++u) {
      const double l = left.at(u, v), r = right.at(u, v), x = position(u, left.width);
      const double square = 0.25 * (l + r) * (l + r);
      weight += square;
      weight_x += square * x;
      weight_xx += square * x * x;
      product += 0.5 * (l * l - r * r);
      product_x += 0.5 * (l * l - r * r) * x;
    }
    const double y = position(v, left.height);
    squares += Eigen::Matrix3d{{weight, weight_x, weight * y},
                               {weight_x, weight_xx, weight_x * y},
                               {weight * y, weight_x * y, weight * y * y}};
    products += Eigen::Vector3d(product, product_x, product * y);
  }
  squares.diagonal().array() += kRidge * squares(0, 0) + 1e-30;
  return squares.ldlt().solve(products);
}

}  // namespace

void even_out_shading(Image& left, Image& right) {
  constexpr int kRounds = 2;     // what the first leaves of q is near q^3 / 12
  constexpr double kMost = 1.4;  // of q on one side in one round: a ratio of 4
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d q = fit_ratio(left, right).cwiseMax(-kMost).cwiseMin(kMost);
    std::vector<float> across(left.width);
    for (int u = 0; u < left.width; ++u) {
      across[u] = static_cast<float>(std::exp(0.5 * (q[0] + q[1] * position(u, left.width))));
    }
    for_rows(left.height, [&](int v) {
      const auto down = static_cast<float>(std::exp(0.5 * q[2] * position(v, left.height)));
      for (int u = 0; u < left.width; ++u) {
        left.at(u, v) /= down * across[u];
        right.at(u, v) *= down * across[u];
      }
    });
  }
}

}  // namespace dualpixel::pipeline::split
