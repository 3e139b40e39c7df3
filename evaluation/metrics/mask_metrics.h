#pragma once
#include "capture/image/image.h"

/// How near a person mask comes to the true one; both of one channel, 0..1, and of one size.
namespace dualpixel::evaluation {

/// Intersection over union, both cut at 0.5; 1 where neither has anything.
double mask_iou(const Image& estimate, const Image& truth);

/// (grad M^ - grad M)^2 at each pixel: forward differences along x and y, squared and added.
Image mask_gradient_errors(const Image& estimate, const Image& truth);

/// Their mean, E[(grad M^ - grad M)^2] of Wadhwa et al. 2018.
double mask_gradient_error(const Image& estimate, const Image& truth);

}  // namespace dualpixel::evaluation
