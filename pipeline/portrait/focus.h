#pragma once
#include <optional>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/segmentation/faces.h"

namespace dualpixel::pipeline {

/// d_focus (Wadhwa et al. 2018, section 5.1): the median disparity over the largest face that is well focused, |median|
/// <= `in_focus_dp_px`, or else over the region tapped; none where neither covers a pixel. `disparity` shows a picture
/// of width x height, smaller or not; `faces`, largest first, and `tap` are in that picture's pixels.
std::optional<double> focus_disparity(const Image& disparity, const std::vector<Face>& faces,
                                      const std::optional<Face>& tap, double in_focus_dp_px, int width, int height);

}  // namespace dualpixel::pipeline
