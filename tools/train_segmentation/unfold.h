#pragma once
#include <torch/torch.h>

#include <cstdint>

#include "pipeline/segmentation/weights.h"
#include "tools/train_segmentation/network.h"

/// Training on from exported weights (export.h), such as a release's, where the run's checkpoint is not at hand.
namespace dualpixel::tools {

/// A network of the same masks, without heatmaps. What export left out is made up for: a filter's norm becomes that of
/// an untrained one; normalization is by the statistics of `input` (batch, 4, 256, 256), so that masks in training are
/// those in evaluation; other stages' masks, of the seed's weights, begin at a half everywhere. Throws InputError for
/// weights of other widths than NetworkShape's, and for those whose results overflow.
Network unfolded(const pipeline::NetworkWeights& weights, const torch::Tensor& input, std::uint64_t seed);

}  // namespace dualpixel::tools
