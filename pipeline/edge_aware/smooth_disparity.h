#pragma once
#include "capture/image/image.h"
#include "pipeline/edge_aware/options.h"
#include "pipeline/option_field.h"

/// From noisy, partly unknown disparity to a smooth map whose edges are the picture's (Wadhwa et al. 2018, section
/// 4.4): reduce to a quarter of the picture's size, bilateral solver, 3 x 3 median, joint bilateral upsampling.
/// run_portrait calls the steps one by one, with the person mask between the first and the second; smooth_disparity()
/// is all of them at once.
namespace dualpixel::pipeline {

struct SmoothOptions {
  int divisor = 4;  ///< the picture's size over the solver's (section 4.4: one-quarter image resolution)
  BilateralGridOptions grid;
  BilateralSolverOptions solver;
  JointUpsampleOptions joint_upsample;
};

OptionFields fields(SmoothOptions& options);

/// Throws InputError where a value is out of its range.
void check(const SmoothOptions& options);

/// A map of one channel and the confidence of each pixel, 0..1; both of one size.
struct ConfidentMap {
  Image value;
  Image confidence;
};

/// The guide that the solver uses, made from a linear RGB picture.
struct SmoothingGuide {
  Image small;     ///< RGB, 0..255 (guide.h), ceil(size / divisor)
  float gain = 1;  ///< by which the picture was brightened; the full-size guide uses the same
};

SmoothingGuide make_smoothing_guide(const Image& linear_rgb, const SmoothOptions& options = {});

/// The map at width x height: means weighted by confidence, so that what is unknown does not mix with what is known;
/// plain means where confidence is 0 throughout. The new confidence is the plain mean. A map that has fewer columns,
/// or half as many rows or fewer, is enlarged bilinearly by the same weights.
ConfidentMap reduce_by_confidence(const ConfidentMap& map, int width, int height);

/// Bilateral solver and 3 x 3 median. `map` has the guide's size.
Image solve_and_median(const ConfidentMap& map, const Image& small_guide, const SmoothOptions& options = {});

/// Joint bilateral upsampling of `small`, of the guide's size, to the size of `linear_rgb`, which the guide was made
/// of.
Image upsample_along_edges(const Image& small, const SmoothingGuide& guide, const Image& linear_rgb,
                           const SmoothOptions& options = {});

/// The whole chain: `map` of any size in, a map of the picture's size out. Throws InputError where an option is out of
/// range or the map's two images differ in size.
Image smooth_disparity(const ConfidentMap& map, const Image& linear_rgb, const SmoothOptions& options = {});

}  // namespace dualpixel::pipeline
