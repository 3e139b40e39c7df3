#pragma once
#include <span>
#include <string_view>

#include "capture/image/image.h"
#include "pipeline/defocus/blur_radius.h"
#include "pipeline/defocus/options.h"

/// Every way of blurring what is out of focus, under one signature. The table holds those that the portrait uses, which
/// run_portrait chooses by mode; evaluation/experiments/defocus_baselines.h has one of baselines. To add a method:
///   1. write it in a file of its own;
///   2. add one row to the table in methods.cpp, or to that of the baselines; experiments read both;
///   3. where it has options of its own, add them to DefocusOptions in options.h, and their fields to those of
///      pipeline/portrait/options.cpp;
///   4. describe it in docs/defocus.md.
namespace dualpixel::pipeline {

struct Defocused;

/// What a method may use, for the time of one call; images are of the picture's size, and those that it does not need
/// may be empty.
struct DefocusInput {
  const Image& rgb;              ///< linear
  const Image& disparity_dp_px;  ///< smoothed
  const Image& person_mask;      ///< 0..1
  BlurMapping mapping;           ///< from disparity to blur radius
};

struct DefocusMethod {
  std::string_view name;
  std::string_view description;  ///< one phrase, for help and tables
  bool by_mask;                  ///< blurs by the person mask, without disparity
  /// Throws InputError where an image that it needs has another size than the picture.
  Defocused (*render)(const DefocusInput& input, const DefocusOptions& options);
};

/// "layers" (render.h: by disparity) and "mask" (mask_blur.h: the background of a person mask).
std::span<const DefocusMethod> defocus_methods();

/// Throws InputError for a name that the table lacks, with the nearest one that it has.
const DefocusMethod& defocus_method_named(std::string_view name);

}  // namespace dualpixel::pipeline
