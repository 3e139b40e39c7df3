#pragma once
#include "capture/image.h"

/// How near a person mask comes to the true one; both of one channel, 0..1, and of one size.
namespace dualpixel::tools {

/// Intersection over union, both cut at 0.5; 1 where neither has anything.
double mask_iou(const Image& estimate, const Image& truth);

/// E[(grad M^ - grad M)^2] of Wadhwa et al. 2018: forward differences along x and y, squared and added, mean over
/// pixels.
double mask_gradient_error(const Image& estimate, const Image& truth);

}  // namespace dualpixel::tools
