#pragma once
#include "capture/image/image.h"

/// The guide of the edge-aware filters: the picture encoded so that equal steps look about equally large.
namespace dualpixel::pipeline {

/// The gain that brings the mean of a linear picture up to 0.2, never below 1: dark pictures have edges too.
float guide_gain(const Image& linear_rgb);

/// 255 * sqrt(gain * linear), clipped to 0..255; RGB. Values that are not finite count as 0 or 255.
Image encode_guide(const Image& linear_rgb, float gain);

}  // namespace dualpixel::pipeline
