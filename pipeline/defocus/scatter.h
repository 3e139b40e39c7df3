#pragma once
#include "pipeline/defocus/aperture.h"
#include "pipeline/defocus/layers.h"

/// Blur by scattering: each pixel spreads its premultiplied color over a disc, or another aperture's shape, of its own
/// radius, in parts that add up to the pixel (Wadhwa et al. 2018, section 5.2). What falls outside the picture is lost,
/// so alpha falls near its borders: divide by alpha to see colors. The blurred layer is laid over `behind`,
/// premultiplied RGBA of the layer's size ("over", Porter and Duff 1984); discs that pile up beyond alpha 1 keep their
/// color.
namespace dualpixel::pipeline {

/// Small radii, brute force: anti-aliased shapes of weight clamp(1/2 + distance inside the rim, 0, 1), normalized; r in
/// steps of 1/16 px. Radius 0 leaves the pixel as it is. Work grows as the square of the largest radius.
void scatter_direct(const Layer& layer, Image& behind, const Aperture& aperture = {});

/// Large radii: shapes of rows that each have the area, the middle and the spread along the row that the ideal shape
/// has within the row's height, scattered as their differences along x, which live on the rim alone, then summed along
/// x. (The paper's rows end at whole pixels, which leaves three quarters of an ideal disc of radius 2.75. A row's end
/// within a pixel is a pair of neighboring differences, and costs no more, as the two fit one register. The paper
/// differentiates along y "without loss of generality": along x such pairs are neighbors in memory.) r in steps of
/// 1/16 px. Equals direct scatter of the same shapes. Work grows as the radius.
void scatter_gradient(const Layer& layer, Image& behind, const Aperture& aperture = {});

}  // namespace dualpixel::pipeline
