#pragma once
#include <functional>
#include <string>

#include "capture/image/image.h"
#include "pipeline/edge_aware/smooth_disparity.h"

/// What the smoothing benchmark compares: one signature for the pipeline's solver and its peers.
namespace dualpixel::evaluation {

/// A disparity with confidence for each pixel of the guide.
struct SmoothingInput {
  pipeline::SmoothingGuide guide;
  pipeline::ConfidentMap map;
};

struct SmoothingMethod {
  std::string family, name;
  int divisor = 4;                                     ///< the capture's size over that which `smooth` works on
  std::function<Image(const SmoothingInput&)> smooth;  ///< up to the median, before upsampling
};

}  // namespace dualpixel::evaluation
