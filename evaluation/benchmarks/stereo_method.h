#pragma once
#include <functional>
#include <string>

#include "capture/image/image.h"
#include "pipeline/disparity/noise_model.h"
#include "pipeline/disparity/upsample.h"

/// What the disparity benchmark compares: one signature for the pipeline's matchers and their peers.
namespace dualpixel::evaluation {

/// Two DP views, linear, normalized signal, and their sensor.
struct StereoPair {
  Image left, right;
  pipeline::ViewSensor sensor;
};

/// A matcher of the pipeline, or a peer. Gives the disparity of every pixel, NaN where it has none; sigma and
/// confidence where it has them.
struct StereoMethod {
  std::string name;
  std::function<pipeline::PixelDisparity(const StereoPair&)> match;
};

}  // namespace dualpixel::evaluation
