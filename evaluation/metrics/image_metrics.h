#pragma once
#include <optional>

#include "capture/image/image.h"

/// Figures that compare two pictures of the same size, with values in 0..1.
namespace dualpixel::evaluation {

/// The picture as a sensor that clips at 1 holds it: values below 0, and NaN, become 0, values above 1 become 1.
Image clipped(const Image& linear);

/// The picture times `gain`, clipped like that and encoded for display with the sRGB curve.
Image displayed(const Image& linear, float gain = 1);

/// Peak signal-to-noise ratio, 10 log10(1 / mean square difference) over all pixels and channels, in decibels; None for
/// identical pictures, whose ratio is infinite.
std::optional<double> psnr_db(const Image& a, const Image& b);

/// Mean structural similarity of the luminances (Rec. 709 weights on the values as given): Wang et al. 2004,
/// "Image Quality Assessment: From Error Visibility to Structural Similarity", Eq. 13 and 17, with an 11 x 11 Gaussian
/// window of sigma 1.5, K1 = 0.01, K2 = 0.03, over the windows that lie inside the picture. None where it is smaller
/// than a window.
std::optional<double> ssim(const Image& a, const Image& b);

}  // namespace dualpixel::evaluation
