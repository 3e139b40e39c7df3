#pragma once
#include "capture/image/image.h"

/// FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images"): how much two pictures that a
/// viewer flips between seem to differ.
namespace dualpixel::evaluation {

/// Pixels of one degree of the visual field: the paper's monitor, .7 m wide with 3840 pixels, seen from .7 m.
inline constexpr double kFlipPixelsPerDegree = 67.02;

/// The difference at every pixel, 0 (none) to 1. `reference` and `test` are sRGB, 0..1, three channels, of one size.
/// Spatial filters by the eye's contrast sensitivity, HyAB distance of Hunt-adjusted L*a*b* compressed by the exponent
/// .7, amplified where edges or points differ: the paper's Eq. 1 to 13 with its constants. Borders are repeated
/// outwards. Throws InputError where sizes or channels differ.
Image flip_map(const Image& reference, const Image& test, double pixels_per_degree = kFlipPixelsPerDegree);

/// Its mean.
double mean_flip(const Image& reference, const Image& test, double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace dualpixel::evaluation
