#pragma once
#include "capture/image/image.h"
#include "pipeline/edge_aware/options.h"
#include "pipeline/option_field.h"

/// Joint bilateral upsampling (Kopf et al. 2007): a small map enlarged so that its edges follow the large picture's.
namespace dualpixel::pipeline {

OptionFields fields(JointUpsampleOptions& options);

/// Each output pixel is the mean over the 3 x 3 small pixels around it, weighted by a Gaussian of the distance and one
/// of the difference between `guide` there and `small_guide` here. Where no small pixel resembles it, distance decides.
/// `small` has one channel and the size of `small_guide`; both guides are RGB, 0..255 (guide.h); `guide` has the
/// output's size. All finite.
Image joint_upsample(const Image& small, const Image& small_guide, const Image& guide,
                     const JointUpsampleOptions& options = {});

}  // namespace dualpixel::pipeline
