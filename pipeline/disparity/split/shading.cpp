#include "pipeline/disparity/split/shading.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel::pipeline::split {
namespace {

/// Position along an axis, from -1 to 1.
double position(int i, int size) { return (2 * i + 1.0) / size - 1; }

/// The light from which on a sample counts no more than others: the median of both views' means. A bright disc out of
/// focus has, by itself, the ratio of a lens's shading.
float typical_light(const Image& left, const Image& right) {
  std::vector<float> sums(left.data.size());
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = std::abs(left.data[i] + right.data[i]);
  const auto middle = sums.begin() + static_cast<std::ptrdiff_t>(sums.size() / 2);
  std::nth_element(sums.begin(), middle, sums.end());
  return 0.5f * *middle;
}

/// q = c + x dx + y dy of least sum of ((left - right - q mean) / max(mean, typical))^2, mean of both views: to first
/// order, what makes both equal.
Eigen::Vector3d fit_ratio(const Image& left, const Image& right, double typical) {
  constexpr double kRidge = 1e-6;  // of the sum of squares: a single row or column leaves a term open
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  for (int v = 0; v < left.height; ++v) {
    double weight = 0, weight_x = 0, weight_xx = 0, product = 0, product_x = 0;
    for (int u = 0; u < left.width; ++u) {
      const double mean = 0.5 * (left.at(u, v) + right.at(u, v)), difference = left.at(u, v) - right.at(u, v);
      const double scale = 1 / std::max({std::abs(mean), std::abs(difference), typical, 1e-30});
      const double square = mean * scale * mean * scale, part = difference * scale * mean * scale;
      const double x = position(u, left.width);
      weight += square;
      weight_x += square * x;
      weight_xx += square * x * x;
      product += part;
      product_x += part * x;
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
  constexpr double kMost = 1.4;  // of q anywhere in one round: a ratio of 4
  const double typical = typical_light(left, right);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Vector3d q = fit_ratio(left, right, typical);
    if (!q.allFinite()) return;
    q *= std::min(1.0, kMost / std::max(q.lpNorm<1>(), kMost));
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
