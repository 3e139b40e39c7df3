#pragma once
#include <span>

#include "capture/image/image.h"
#include "pipeline/defocus/methods.h"

/// Simpler ways of blurring as baselines, under the pipeline's signature. All at full resolution with anti-aliased
/// discs, on all cores.
namespace dualpixel::evaluation {

/// Each pixel is the mean over a disc of its own radius (Wadhwa et al. 2018, Eq. 6): sharp neighbors bleed into it.
Image blur_by_gathering(const Image& rgb, const Image& radius_px);

/// "naive gather" is blur_by_gathering. "single pass" spreads each pixel over a disc of its own radius, all at once,
/// and divides by the weights that arrive: blur spreads over what is sharp in front of it. "mask and uniform blur"
/// blurs the picture by mask_blur's radius, the person included, and lays the person over it, without matting (Shen et
/// al. 2016 as in the paper's user study).
std::span<const pipeline::DefocusMethod> defocus_baselines();

}  // namespace dualpixel::evaluation
