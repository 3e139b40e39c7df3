#pragma once
#include <vector>

#include "evaluation/benchmarks/stereo_method.h"

namespace dualpixel::evaluation {

/// OpenCV's StereoBM and StereoSGBM; none where the build has no OpenCV (DUALPIXEL_OPENCV).
std::vector<StereoMethod> opencv_stereo_methods();

}  // namespace dualpixel::evaluation
