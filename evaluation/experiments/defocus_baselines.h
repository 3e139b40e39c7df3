#pragma once
#include "capture/image/image.h"

/// Simpler ways of blurring, to compare ours with. All at full resolution with anti-aliased discs, on all cores.
namespace dualpixel::evaluation {

/// Each pixel is the mean over a disc of its own radius (Wadhwa et al. 2018, Eq. 7): sharp neighbours bleed into it.
Image blur_by_gathering(const Image& rgb, const Image& radius_px);

/// Each pixel is spread over a disc of its own radius, all at once, divided by the weights that arrive: what is blurred
/// spreads over what is sharp in front of it.
Image blur_in_one_pass(const Image& rgb, const Image& radius_px);

/// The picture blurred by one radius, the person included, and the person laid over it: a mask and nothing else, no
/// matting (Shen et al. 2016 as the paper's user study has it).
Image blur_behind_mask(const Image& rgb, const Image& mask, float radius_px);

}  // namespace dualpixel::evaluation
