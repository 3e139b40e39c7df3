#pragma once
#include <string>

#include "capture/image/image.h"
#include "pipeline/disparity/upsample.h"

namespace dualpixel::pipeline {

/// What a method of anybody's making found between the views of the first frame: maps of the views' size, upright.
struct GivenDisparity {
  Image disparity_dp_px;  ///< right(x + d) = left(x); not finite: not found
  Image confidence;       ///< 0 to 1, not finite: 0; may be empty
  Image sigma_dp_px;      ///< predicted standard deviation, not finite: not known; may be empty
  // what begins the messages about them
  std::string disparity_name = "disparity", confidence_name = "confidence", sigma_name = "sigma";
};

/// The same as a matcher gives it: finite, with a confidence, which is 0 where nothing was found. Where none is given
/// it is 1 / (1 + (sigma / 0.3 DP px)^2), as the likelihood matcher has it, or without sigma 1. Throws InputError where
/// a map is not one channel of width x height, a confidence is outside [0, 1] or a sigma below 0.
PixelDisparity as_matched(const GivenDisparity& given, int width, int height);

}  // namespace dualpixel::pipeline
