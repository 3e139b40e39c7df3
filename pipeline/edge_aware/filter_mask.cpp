#include "pipeline/edge_aware/filter_mask.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/resample.h"
#include "capture/image/rows.h"
#include "pipeline/edge_aware/bilateral_grid.h"
#include "pipeline/edge_aware/bilateral_solver.h"
#include "pipeline/edge_aware/joint_upsample.h"

namespace dualpixel::pipeline {

OptionFields fields(FilterMaskOptions& options) {
  OptionFields all = {{"on", &options.on, 0, 1, "1: yes, 0: no", "ours"},
                      {"erosion", &options.erosion, 0, 1, "of the larger side", "3.4: 0.05"},
                      {"sigmoid_slope", &options.sigmoid_slope, 0, 1e6, "", "ours"},
                      {"blur_sigma_px", &options.blur_sigma_px, 0.1, 100, "half-resolution px", "ours"}};
  for (const OptionFields& group : {grouped("grid", fields(options.grid)), grouped("solver", fields(options.solver)),
                                    grouped("upsample", fields(options.upsample))}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

Image erode(const Image& image, int side) {
  const int reach = side / 2;
  const int width = image.width, height = image.height;
  Image across(width, height), out(width, height);
  for_rows(height, [&](int y) {
    const float* from = image.row(y);
    float* to = across.row(y);
    std::copy(from, from + width, to);
    for (int k = 1; k <= std::min(reach, width - 1); ++k) {
      for (int x = 0; x < width - k; ++x) to[x] = std::min(to[x], from[x + k]);
      for (int x = k; x < width; ++x) to[x] = std::min(to[x], from[x - k]);
    }
  });
  for_rows(height, [&](int y) {
    float* to = out.row(y);
    std::copy(across.row(y), across.row(y) + width, to);
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height - 1); ++v) {
      const float* from = across.row(v);
      for (int x = 0; x < width; ++x) to[x] = std::min(to[x], from[x]);
    }
  });
  return out;
}

Image gaussian_blur(const Image& image, float sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  const int width = image.width, height = image.height;
  std::vector<float> kernel(2 * reach + 1);
  float total = 0;
  for (int k = -reach; k <= reach; ++k) {
    total += kernel[k + reach] = std::exp(-0.5f * static_cast<float>(k * k) / (sigma_px * sigma_px));
  }
  for (float& weight : kernel) weight /= total;
  Image across(width, height), out(width, height);
  for_rows(height, [&](int y) {
    for (int k = -reach; k <= reach; ++k) {
      for (int x = 0; x < width; ++x) {
        across.row(y)[x] += kernel[k + reach] * image.row(y)[std::clamp(x + k, 0, width - 1)];
      }
    }
  });
  for_rows(height, [&](int y) {
    for (int k = -reach; k <= reach; ++k) {
      const float* from = across.row(std::clamp(y + k, 0, height - 1));
      for (int x = 0; x < width; ++x) out.row(y)[x] += kernel[k + reach] * from[x];
    }
  });
  return out;
}

Image filter_mask(const Image& mask, const Image& guide, const FilterMaskOptions& options) {
  if (options.on == 0) {
    return mask.width > guide.width ? resize_area(mask, guide.width, guide.height)
                                    : resize_bilinear(mask, guide.width, guide.height);
  }
  const int width = (guide.width + 1) / 2, height = (guide.height + 1) / 2;
  const Image half_guide = resize_area(guide, width, height);
  const Image coarse = mask.width > width ? resize_area(mask, width, height) : resize_bilinear(mask, width, height);
  Image confidence(width, height);
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const float certainty = 2 * coarse.row(y)[x] - 1;
      confidence.row(y)[x] = certainty * certainty;
    }
  });
  const int reach = static_cast<int>(0.5f * options.erosion * static_cast<float>(std::max(width, height)));
  confidence = erode(confidence, 2 * reach + 1);

  const BilateralGrid grid = make_bilateral_grid(half_guide, options.grid);
  Image filtered = solve_bilateral(grid, half_guide, coarse, confidence, options.solver).value;
  for_rows(height, [&](int y) {
    float* value = filtered.row(y);
    for (int x = 0; x < width; ++x) value[x] = 1 / (1 + std::exp(-options.sigmoid_slope * (value[x] - 0.5f)));
  });
  return joint_upsample(gaussian_blur(filtered, options.blur_sigma_px), half_guide, guide, options.upsample);
}

}  // namespace dualpixel::pipeline
