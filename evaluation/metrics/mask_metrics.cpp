#include "evaluation/metrics/mask_metrics.h"

#include <numeric>

#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/edge_aware/guide.h"

namespace dualpixel::evaluation {

Image filtered_mask(const Image& mask, const Image& picture) {
  return pipeline::filter_mask(mask, pipeline::encode_guide(picture, pipeline::guide_gain(picture)));
}

double mask_iou(const Image& estimate, const Image& truth) {
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    const bool e = estimate.data[i] > 0.5F, t = truth.data[i] > 0.5F;
    both += e && t ? 1 : 0;
    either += e || t ? 1 : 0;
  }
  return either == 0 ? 1 : static_cast<double>(both) / static_cast<double>(either);
}

Image mask_gradient_errors(const Image& estimate, const Image& truth) {
  const auto error = [&](int x, int y) { return estimate.at(x, y) - truth.at(x, y); };
  Image errors(truth.width, truth.height);
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      const float dx = x + 1 < truth.width ? error(x + 1, y) - error(x, y) : 0;
      const float dy = y + 1 < truth.height ? error(x, y + 1) - error(x, y) : 0;
      errors.at(x, y) = dx * dx + dy * dy;
    }
  }
  return errors;
}

double mask_gradient_error(const Image& estimate, const Image& truth) {
  const Image errors = mask_gradient_errors(estimate, truth);
  return std::accumulate(errors.data.begin(), errors.data.end(), 0.0) / static_cast<double>(errors.pixel_count());
}

}  // namespace dualpixel::evaluation
