#pragma once
#include <optional>

#include "pipeline/disparity/kernel_skew.h"
#include "pipeline/disparity/noise_model.h"
#include "pipeline/option_field.h"

namespace dualpixel::pipeline {

struct LikelihoodMatchOptions {
  int range_px = 16;               ///< shifts from -range to range are tried, DP pixels; 2..64
  std::optional<ViewNoise> noise;  ///< of one view's pixel; estimated from the views where not given
  SkewField skew;                  ///< of the views' kernels
  float white = 1;                 ///< normalized signal at which the views clip
  float clipped = 0.98f;           ///< pixels at or above this share of it are invalid
  /// Standard deviation of the offset between the views that is left after the local gain is taken out, over the
  /// signal.
  float offset_search = 0.03f;  ///< while the disparity is unknown
  float offset = 0.002f;        ///< once it is known
  /// Share of the cost's contrast over the range by which an alternative may exceed the best and still be likely: what
  /// kernels that are mirrored rather than equal, and whole-pixel steps, do to the cost of a true match.
  float model_error = 0.02f;
  float neighbor_weight = 0.25f;       ///< of the costs of each of four neighboring tiles
  float confident_sigma_dp_px = 0.3f;  ///< predicted error at which confidence is 1/2, DP px
};

OptionFields fields(LikelihoodMatchOptions& options);

/// Throws InputError where a value is out of its range, or the noise is negative or not finite.
void check(const LikelihoodMatchOptions& options);

}  // namespace dualpixel::pipeline
