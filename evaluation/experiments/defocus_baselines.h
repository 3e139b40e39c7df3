#pragma once
#include <span>

#include "capture/image/image.h"
#include "pipeline/defocus/methods.h"

/// Simpler ways of blurring as baselines, under the pipeline's signature. All at full resolution with anti-aliased
/// discs, on all cores.
namespace dualpixel::evaluation {

/// Each pixel is the mean over a disc of its own radius (Wadhwa et al. 2018, Eq. 7): sharp neighbors bleed into it.
Image blur_by_gathering(const Image& rgb, const Image& radius_px);

/// In this order:
///   naive gather           blur_by_gathering
///   single pass            each pixel is spread over a disc of its own radius, all at once, divided by the weights
///   that
///                          arrive: what is blurred spreads over what is sharp in front of it
///   mask and uniform blur  the picture blurred by mask_blur's radius, the person included, and the person laid over
///   it:
///                          a mask and nothing else, no matting (Shen et al. 2016 as in the paper's user study)
std::span<const pipeline::DefocusMethod> defocus_baselines();

}  // namespace dualpixel::evaluation
