#pragma once
#include "pipeline/option_field.h"

namespace dualpixel::pipeline {

struct SplitMatchOptions {
  int range_px = 16;                ///< largest |disparity| that is tried, DP px; 4..64
  float alpha = 0;                  ///< disparity over signed blur diameter, 0.02 to 4 / (3 pi); 0: a phone's
  float white = 1;                  ///< normalized signal at which the views clip
  float pixel_height = 1;           ///< of the views' pixels, over their width; above 0
  float clipped = 0.98f;            ///< pixels at or above this share of it are invalid
  float low_pass_px = 4.5;          ///< standard deviation of the Gaussian before matching, DP px
  float high_pass_px = 20;          ///< ... of the local mean that is taken out, DP px
  float window_px = 12;             ///< ... of the window over which squared differences are summed, DP px
  float near_focus_dp_px = 1.2f;    ///< up to this |disparity| the likelihood matcher answers; 0: nowhere
  float confident_sigma_dp_px = 1;  ///< predicted error at which confidence is 1/2, DP px
};

inline constexpr float kPhoneAlpha = 0.21f;  ///< of a phone's soft split: for cameras that state none

/// SplitMatchOptions' for a camera that states `alpha`: the same, at most that of two halves that share no light in the
/// middle of the pixel, 4 / (3 pi); 0 for what no camera has (under .02, over .6) or is not known.
float alpha_of_camera(float alpha);

OptionFields fields(SplitMatchOptions& options);

/// Throws InputError where a value is out of its range.
void check(const SplitMatchOptions& options);

}  // namespace dualpixel::pipeline
