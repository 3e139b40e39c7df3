#pragma once
#include "capture/capture.h"
#include "capture/image/image.h"

/// Noise of DP views, and the best that any matcher can make of them.
namespace dualpixel::pipeline {

/// Variance of a pixel of one view whose mean is x, in the normalised signal (0 black, 1 clipped): shot * x + read.
struct ViewNoise {
  float shot = 0;
  float read = 0;
};

/// What the capture states; {0, 0} where it is unknown.
inline ViewNoise view_noise(const Exposure& exposure) {
  const double range = exposure.white_level_dn - exposure.black_level_dn;
  return {static_cast<float>(exposure.dp_noise.shot_dn / range),
          static_cast<float>(exposure.dp_noise.read_dn2 / (range * range))};
}

/// The profile read off the views themselves, as shot noise alone: the lower quartile, over 8 x 8 tiles, of the
/// variance of second differences along both axes over the mean. Texture finer than 3 px counts as noise. Never 0.
ViewNoise estimate_noise(const Image& left, const Image& right);

/// Cramer-Rao bound: no unbiased estimate of a tile's shift has a smaller standard deviation, DP px, than
///     1 / sqrt(sum over the tile of I'^2 / (2 (shot * I + read)))
/// where I is the noise-free view, the same in both views but for the shift, and I' its derivative along x. One pixel
/// for each tile, ceil(size / tile_px) of them; infinite where the view is constant. For tests and charts: it needs
/// truth.
Image shift_bound_dp_px(const Image& noise_free_view, const ViewNoise& noise, int tile_px = 8);

}  // namespace dualpixel::pipeline
