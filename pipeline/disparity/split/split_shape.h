#pragma once

/// How the light of a pupil is shared: at p, -1 to 1 along the baseline, the left view has (1 - g(p)) / 2 of it and the
/// right view (1 + g(p)) / 2. g(p) = p / k is that of a soft split, k = 1 / (4 alpha); where alpha is above 1/4, k is
/// below 1 and g between -1 and 1, up to the sign of p for a hard split.
namespace dualpixel::pipeline::split {

/// k for alpha, above 0, up to 4 / (3 pi).
double ramp_width(double alpha);

/// Third central moments of the right view's kernel, for a disc of radius 1; left's are the negative.
struct ShapeSkew {
  double xxx = 0, xyy = 0;  ///< x along the baseline
};

/// Those that, without any higher ones, would shift waves of `frequency`, radians a radius, 0.1 to 3.8, as the kernels
/// do: xxx waves along x, xyy waves that are all but along y. At low frequencies these are the moments.
ShapeSkew skew_at(double alpha, double frequency);

}  // namespace dualpixel::pipeline::split
