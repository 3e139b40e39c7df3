#pragma once
#include <array>
#include <vector>

#include "capture/image/image.h"

/// Statistics by which pictures of scenes are compared with photographs, unaffected by rendering noise.
namespace dualpixel::evaluation {

/// The same picture with independent noise: means of products of different ones hold none of it.
using NoisyPictures = std::array<Image, 4>;

/// Slope of the logarithm of amplitude over the logarithm of spatial frequency, all orientations together, of the
/// largest centered square, from 4 cycles a picture to a quarter of a cycle a pixel, each octave with the same weight.
/// Photographs: -1.0 (Field 1987), -.8 to -1.5, -1.2 in the mean (Tolhurst, Tadmor & Chao 1992). `log_luminance`: one
/// channel, 48 pixels or more each way. NaN where there is no contrast.
double amplitude_slope(const NoisyPictures& log_luminance);

/// Of differences of neighbors, horizontal and vertical ones together.
struct GradientMoments {
  double square = 0, fourth = 0;  ///< means; over many pictures they are averaged before dividing
  double deviation() const;
  double kurtosis() const;  ///< 3: normally distributed
};
GradientMoments gradient_moments(const NoisyPictures& log_luminance);

/// Values below which 5, 25, 50, 75 and 95 % of `values` lie. Empty: zeros.
std::array<double, 5> quantiles(std::vector<double> values);

}  // namespace dualpixel::evaluation
