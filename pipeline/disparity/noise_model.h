#pragma once
#include "capture/capture.h"
#include "capture/image/image.h"

/// Noise of DP views.
namespace dualpixel::pipeline {

/// Variance of a pixel of one view whose mean is x, in the normalized signal (0 black, 1 clipped): shot * x + read.
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

}  // namespace dualpixel::pipeline
