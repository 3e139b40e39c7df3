#pragma once
#include "capture/image/image.h"

/// How near a person mask comes to the true one; both of one channel, 0..1, and of one size.
namespace dualpixel::evaluation {

/// `mask` as the pipeline filters it against `picture`, RGB in linear light, at the picture's size.
Image filtered_mask(const Image& mask, const Image& picture);

/// Intersection over union, both cut at 0.5; 1 where neither has anything.
double mask_iou(const Image& estimate, const Image& truth);

/// (grad M^ - grad M)^2 at each pixel: forward differences along x and y, squared and added.
Image mask_gradient_errors(const Image& estimate, const Image& truth);

/// Their mean, E[(grad M^ - grad M)^2] of Wadhwa et al. 2018.
double mask_gradient_error(const Image& estimate, const Image& truth);

}  // namespace dualpixel::evaluation
