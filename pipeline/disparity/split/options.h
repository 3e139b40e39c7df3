#pragma once
#include "pipeline/option_field.h"

namespace dualpixel::pipeline {

struct SplitMatchOptions {
  int range_px = 16;              ///< largest |disparity| that is tried, DP px; 4..64
  float alpha = 0;                ///< disparity over signed blur diameter, is_alpha(); 0: the camera's, else a phone's
  float white = 1;                ///< normalized signal at which the views clip
  float pixel_height = 1;         ///< of the views' pixels, over their width; above 0
  float clipped = 0.98f;          ///< pixels at or above this share of it are invalid
  float low_pass_px = 6;          ///< standard deviation of the Gaussian before matching, DP px
  float high_pass_px = 20;        ///< ... of the local mean that is taken out, DP px
  float window_px = 12;           ///< ... of the window over which squared differences are summed, DP px
  float near_focus_dp_px = 1.2f;  ///< up to this |disparity| the likelihood matcher answers; 0: nowhere
  float confident_sigma_dp_px = 1;  ///< predicted error at which confidence is 1/2, DP px
};

inline constexpr float kPhoneAlpha = 0.21f;  ///< of a soft split; where nothing is known of the camera's

/// What a split can have: up to that of two halves that share no light, 4 / (3 pi).
bool is_alpha(float alpha);

OptionFields fields(SplitMatchOptions& options);

/// Throws InputError where a value is out of its range.
void check(const SplitMatchOptions& options);

}  // namespace dualpixel::pipeline
