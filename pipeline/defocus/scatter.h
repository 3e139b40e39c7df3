#pragma once
#include "pipeline/defocus/aperture.h"
#include "pipeline/defocus/layers.h"

/// Blur by scattering (Wadhwa et al. 2018, section 5.2): each pixel spreads its premultiplied color [R, G, B, alpha]
/// over a disc of its own radius, or over another aperture's shape (aperture.h).
///
/// The weights of a shape add up to 1, so an inner pixel loses no light. What falls outside the picture is lost, so
/// alpha falls near the picture's borders: divide by alpha to get colors. Where discs pile up beyond alpha 1, all four
/// channels are divided by it: the paper says nothing, and "over" has no meaning for an alpha above 1. The blurred
/// layer is then composited behind `front` (premultiplied RGBA of the layer's size; lay_over() of rgba.h): nearer
/// layers come first.
///
/// Radii are in pixels of the layer, rounded to 1/16 px.
namespace dualpixel::pipeline {

/// For small radii: adds every weight of every shape. A pixel's weight is clamp(1/2 + distance inside the rim, 0, 1),
/// normalized, which makes the rim anti-aliased. Radius 0 leaves the pixel as it is. Time grows with the square of the
/// radius.
void scatter_direct(const Layer& layer, Image& front, const Aperture& aperture = {});

/// For large radii: scatters the derivative of each shape along x, then integrates along x (Eq. 7). The derivative
/// differs from 0 only at both ends of a row, so time grows with the radius, not with its square.
///
/// Each row of a shape has one constant weight. The row's area, center of mass and spread along x equal those of the
/// ideal shape within that row, so a row may end inside a pixel: its end is then a pair of neighboring differences.
///
/// Two departures from the paper. Its rows end at whole pixels, so that a disc of radius 2.75 shares only 77 % of its
/// weight with the ideal disc; here it is 97 % (docs/defocus.md). And it differentiates along y "without loss of
/// generality"; along x the two differences of a row's end are neighbors in memory and fit one register.
///
/// The result equals direct scattering of the same shapes, up to rounding.
void scatter_gradient(const Layer& layer, Image& front, const Aperture& aperture = {});

}  // namespace dualpixel::pipeline
