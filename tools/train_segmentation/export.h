#pragma once
#include <string>
#include <vector>

#include "tools/train_segmentation/network.h"

/// A trained network for inference: what pipeline/segmentation/network.h reads.
namespace dualpixel::tools {

/// A convolution whose batch normalization is folded into it: y = weight * x + bias.
struct FoldedConv {
  std::string name;      ///< of the layer, as the network registers it: "stage0.down1"
  torch::Tensor weight;  ///< (out, in, kernel, kernel)
  torch::Tensor bias;    ///< (out)
};

/// All that a mask of the last stage needs; other stages' masks and all heatmaps are left out.
std::vector<FoldedConv> folded_layers(Network& network);

/// The layers as a safetensors file of 16-bit floats, "NAME.weight" and "NAME.bias".
std::string safetensors(const std::vector<FoldedConv>& layers);

}  // namespace dualpixel::tools
