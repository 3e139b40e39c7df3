#pragma once
#include <string>

#include "pipeline/segmentation/weights.h"

/// The person network (pipeline/segmentation/network.h) for other people's tools.
namespace dualpixel::tools {

/// An ONNX model, operator set 13, 32-bit floats:
///   "input"  (N, 4, 256, 256): sRGB in 0..1 minus 0.5, black around the picture, and the face's Gaussian
///   "mask"   (N, 1, 256, 256), 0..1
std::string onnx_model(const pipeline::NetworkWeights& weights);

}  // namespace dualpixel::tools
