#pragma once
#include "pipeline/defocus/layers.h"

/// Disc blur by scattering: each pixel spreads its premultiplied colour over a disc of its own radius, in equal parts
/// that add up to the pixel (Wadhwa et al. 2018, section 5.2). What falls outside the picture is lost, so alpha falls
/// near its borders: divide by alpha to see colours. Alpha may exceed 1 where discs of different sizes pile up.
namespace dualpixel::pipeline {

/// Small radii, brute force: anti-aliased discs of weight clamp(r + 1/2 - distance, 0, 1), normalised; r in steps of
/// 1/16 px. Radius 0 leaves the pixel as it is. Work grows as the square of the largest radius.
Image scatter_direct(const Layer& layer);

/// Large radii: rasterised discs (all pixels whose centres lie within r), scattered as their differences along x, which
/// live on the circle alone, then summed along x. r in steps of 1/8 px. Equals direct scatter of the same discs.
Image scatter_gradient(const Layer& layer);

}  // namespace dualpixel::pipeline
