#include "tools/mask_metrics.h"

#include <cmath>

namespace dualpixel::tools {

double mask_iou(const Image& estimate, const Image& truth) {
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    const bool e = estimate.data[i] > 0.5F, t = truth.data[i] > 0.5F;
    both += e && t ? 1 : 0;
    either += e || t ? 1 : 0;
  }
  return either == 0 ? 1 : static_cast<double>(both) / static_cast<double>(either);
}

double mask_gradient_error(const Image& estimate, const Image& truth) {
  const auto error = [&](int x, int y) { return static_cast<double>(estimate.at(x, y)) - truth.at(x, y); };
  double sum = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (x + 1 < truth.width) sum += std::pow(error(x + 1, y) - error(x, y), 2);
      if (y + 1 < truth.height) sum += std::pow(error(x, y + 1) - error(x, y), 2);
    }
  }
  return sum / static_cast<double>(truth.pixel_count());
}

}  // namespace dualpixel::tools
