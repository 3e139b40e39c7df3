#pragma once
#include "capture/image/image.h"
#include "evaluation/baselines/bilateral_space.h"

/// Barron et al. 2015, "Fast Bilateral-Space Stereo for Synthetic Defocus", which Wadhwa et al. 2018 compare with, on
/// dual-pixel views: intervals, then labels in bilateral space, then pixels.
namespace dualpixel::evaluation {

/// Sizes in px are those of a picture 2688 px wide and scale with it, as ours do. The paper's grid has cells of 32 px;
/// it has no noise to speak of, and no disparity between whole pixels: what MatchIntervalOptions say of these is ours.
struct BilateralSpaceStereoOptions {
  MatchIntervalOptions match;
  double range_dp_px = 4;                  ///< of a picture 2688 px wide; at least 1 DP px of any
  double window_px = 32;                   ///< columns and rows in which all must match; at least 5 and 3 DP px
  float cell_px = 32;                      ///< along x and y
  float cell_luma = 16, cell_chroma = 12;  ///< of 255 levels
  BilateralSpaceOptions solve;
};

/// The disparity of every pixel of `linear_rgb`, DP px. Views are linear, normalized signal, of any size; each of their
/// pixels speaks for those of the picture that it covers. Vertices are interpolated (pipeline::interpolate) where the
/// paper looks them up and smooths the blocks away with a domain transform.
Image bilateral_space_stereo(const Image& left, const Image& right, const Image& linear_rgb,
                             const BilateralSpaceStereoOptions& options = {});

}  // namespace dualpixel::evaluation
