#include "pipeline/edge_aware/smooth_disparity.h"

#include "capture/error.h"
#include "capture/image/median.h"
#include "capture/image/resample.h"
#include "pipeline/edge_aware/bilateral_grid.h"
#include "pipeline/edge_aware/bilateral_solver.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/edge_aware/joint_upsample.h"

namespace dualpixel::pipeline {

OptionFields fields(SmoothOptions& options) {
  OptionFields all = {{"divisor", &options.divisor, 1, 64, "", "4.4: 4"}};
  for (const OptionFields& group : {grouped("grid", fields(options.grid)), grouped("solver", fields(options.solver)),
                                    grouped("joint_upsample", fields(options.joint_upsample))}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

void check(const SmoothOptions& options) { check_options("smooth", options); }

SmoothingGuide make_smoothing_guide(const Image& linear_rgb, const SmoothOptions& options) {
  const auto reduced = [&](int size) { return (size + options.divisor - 1) / options.divisor; };
  const Image small = resize_area(linear_rgb, reduced(linear_rgb.width), reduced(linear_rgb.height));
  const float gain = guide_gain(small);
  return {encode_guide(small, gain), gain};
}

ConfidentMap reduce_by_confidence(const ConfidentMap& map, int width, int height) {
  const bool enlarge = map.value.width < width || 2 * map.value.height <= height;
  const auto resized = [&](const Image& image) {
    return enlarge ? resize_bilinear(image, width, height) : resize_area(image, width, height);
  };
  Image weighted = map.value;
  for (std::size_t i = 0; i < weighted.data.size(); ++i) weighted.data[i] *= map.confidence.data[i];
  weighted = resized(weighted);
  ConfidentMap reduced{resized(map.value), resized(map.confidence)};
  for (std::size_t i = 0; i < weighted.data.size(); ++i) {
    const float confidence = reduced.confidence.data[i];
    if (confidence > 1e-6f) reduced.value.data[i] = weighted.data[i] / confidence;
  }
  return reduced;
}

Image solve_and_median(const ConfidentMap& map, const Image& small_guide, const SmoothOptions& options) {
  const BilateralGrid grid = make_bilateral_grid(small_guide, options.grid);
  return median_3x3(solve_bilateral(grid, small_guide, map.value, map.confidence, options.solver).value);
}

Image upsample_along_edges(const Image& small, const SmoothingGuide& guide, const Image& linear_rgb,
                           const SmoothOptions& options) {
  return joint_upsample(small, guide.small, encode_guide(linear_rgb, guide.gain), options.joint_upsample);
}

Image smooth_disparity(const ConfidentMap& map, const Image& linear_rgb, const SmoothOptions& options) {
  check(options);
  if (!map.value.same_size(map.confidence)) {
    throw InputError("smooth: disparity and confidence must have one size");
  }
  const SmoothingGuide guide = make_smoothing_guide(linear_rgb, options);
  const ConfidentMap small = reduce_by_confidence(map, guide.small.width, guide.small.height);
  return upsample_along_edges(solve_and_median(small, guide.small, options), guide, linear_rgb, options);
}

}  // namespace dualpixel::pipeline
