#include "evaluation/experiments/defocus_baselines.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/defocus/blur_radius.h"
#include "pipeline/defocus/defocused.h"

namespace dualpixel::evaluation {
namespace {

float disc_weight(int dx, int dy, float radius_px) {
  const float distance = std::sqrt(static_cast<float>(dx * dx + dy * dy));
  return std::clamp(radius_px + 0.5f - distance, 0.0f, 1.0f);
}

float disc_sum(float radius_px) {
  const int reach = static_cast<int>(std::ceil(radius_px + 0.5f)) - 1;
  float sum = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) sum += disc_weight(dx, dy, radius_px);
  }
  return sum;
}

/// Means over the pixels within `reach`, each with weight(neighbor's index, pixel's index, dx, dy).
template <typename Weight>
Image weighted_means(const Image& rgb, int reach, const Weight& weight) {
  Image out(rgb.width, rgb.height, 3);
  tbb::parallel_for(0, rgb.height, [&](int y) {
    for (int x = 0; x < rgb.width; ++x) {
      float sums[4] = {};
      for (int v = std::max(y - reach, 0); v <= std::min(y + reach, rgb.height - 1); ++v) {
        for (int u = std::max(x - reach, 0); u <= std::min(x + reach, rgb.width - 1); ++u) {
          const float w = weight(v * rgb.width + u, y * rgb.width + x, u - x, v - y);
          if (w == 0) continue;
          for (int c = 0; c < 3; ++c) sums[c] += w * rgb.row(v)[3 * u + c];
          sums[3] += w;
        }
      }
      for (int c = 0; c < 3; ++c) out.row(y)[3 * x + c] = sums[c] / sums[3];
    }
  });
  return out;
}

int reach_of(const Image& radius_px) {
  return static_cast<int>(std::ceil(*std::max_element(radius_px.data.begin(), radius_px.data.end()) + 0.5f));
}

}  // namespace

Image blur_by_gathering(const Image& rgb, const Image& radius_px) {
  return weighted_means(rgb, reach_of(radius_px),
                        [&](int, int to, int dx, int dy) { return disc_weight(dx, dy, radius_px.data[to]); });
}

namespace {

pipeline::Defocused gather(const pipeline::DefocusInput& input, const pipeline::DefocusOptions&) {
  return {blur_by_gathering(input.rgb, blur_radii(input.disparity_dp_px, input.mapping)), {}, {}};
}

pipeline::Defocused spread_in_one_pass(const pipeline::DefocusInput& input, const pipeline::DefocusOptions&) {
  const Image radius_px = blur_radii(input.disparity_dp_px, input.mapping);
  Image sums = radius_px;
  for (float& value : sums.data) value = disc_sum(value);
  return {weighted_means(input.rgb, reach_of(radius_px),
                         [&](int from, int, int dx, int dy) {
                           return disc_weight(dx, dy, radius_px.data[from]) / sums.data[from];
                         }),
          {},
          {}};
}

pipeline::Defocused blur_behind_mask(const pipeline::DefocusInput& input, const pipeline::DefocusOptions& options) {
  const Image &rgb = input.rgb, &mask = input.person_mask;
  const auto radius_px =
      static_cast<float>(options.mask_blur.radius_px * rgb.width / options.mask_blur.reference_width_px);
  Image out = blur_by_gathering(rgb, Image(rgb.width, rgb.height, 1, radius_px));
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] += mask.data[i / 3] * (rgb.data[i] - out.data[i]);
  return {std::move(out), {}, {}};
}

constexpr pipeline::DefocusMethod kBaselines[] = {
    {"naive gather", "the mean over a disc of each pixel's own radius", false, gather},
    {"single pass", "each pixel spread over a disc of its own radius, all at once", false, spread_in_one_pass},
    {"mask and uniform blur", "the whole picture by one radius, the person laid over it", true, blur_behind_mask},
};

}  // namespace

std::span<const pipeline::DefocusMethod> defocus_baselines() { return kBaselines; }

}  // namespace dualpixel::evaluation
