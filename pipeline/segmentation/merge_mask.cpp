#include "pipeline/segmentation/merge_mask.h"

#include <algorithm>
#include <cmath>

#include "capture/image/rows.h"
#include "pipeline/disparity/upsample.h"

namespace dualpixel::pipeline {
namespace {

/// Mean over the pixels of [x0, x1) x [y0, y1) that `inside` accepts, weighted by confidence where there is any.
template <typename Inside>
float weighted_mean(const PixelDisparity& map, int x0, int x1, int y0, int y1, const Inside& inside) {
  double weighted = 0, weights = 0, plain = 0, count = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      if (!inside(x, y)) continue;
      const double d = map.disparity_dp_px.at(x, y);
      const double confidence = map.confidence.at(x, y);
      weighted += confidence * d;
      weights += confidence;
      plain += d;
      count += 1;
    }
  }
  if (weights > 0) return static_cast<float>(weighted / weights);
  return count > 0 ? static_cast<float>(plain / count) : 0.0f;
}

}  // namespace

OptionFields fields(MergeMaskOptions& options) {
  return {{"interior", &options.interior, 0, 1, "mask value", "4.3: 0.94"}};
}

float face_disparity(const PixelDisparity& map, const std::array<double, 4>& face) {
  const auto inside = [](double edge, int size) { return static_cast<int>(std::clamp<double>(edge, 0, size)); };
  const int width = map.disparity_dp_px.width, height = map.disparity_dp_px.height;
  return weighted_mean(map, inside(std::floor(face[0]), width), inside(std::ceil(face[0] + face[2]), width),
                       inside(std::floor(face[1]), height), inside(std::ceil(face[1] + face[3]), height),
                       [](int, int) { return true; });
}

float interior_disparity(const PixelDisparity& map, const Image& mask, const MergeMaskOptions& options) {
  return weighted_mean(map, 0, mask.width, 0, mask.height,
                       [&](int x, int y) { return mask.at(x, y) > options.interior; });
}

PixelDisparity flatten_person(PixelDisparity map, const Image& mask, float person_dp_px,
                              const MergeMaskOptions& options) {
  for_rows(mask.height, [&](int y) {
    for (int x = 0; x < mask.width; ++x) {
      if (!(mask.at(x, y) > options.interior)) continue;
      map.disparity_dp_px.at(x, y) = person_dp_px;
      map.confidence.at(x, y) = 1;
    }
  });
  return map;
}

}  // namespace dualpixel::pipeline
