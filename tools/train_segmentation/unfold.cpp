#include "tools/train_segmentation/unfold.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "capture/error.h"
#include "tools/train_segmentation/checkpoint.h"

namespace dualpixel::tools {
namespace {

torch::Tensor tensor_of(const std::vector<float>& values) { return torch::tensor(values); }

/// The layer's convolution times a filter's norm is the exported one.
void unfold(ConvImpl& layer, const pipeline::ConvWeights& folded) {
  const torch::Tensor weight = tensor_of(folded.weight).view(layer.conv->weight.sizes());
  const torch::Tensor gain = (weight.flatten(1).norm(2, 1) / std::sqrt(2)).clamp_min(1e-6);  // He et al. 2015
  layer.conv->weight.copy_(weight / gain.view({-1, 1, 1, 1}));
  layer.norm->weight.copy_(gain);
  layer.norm->bias.copy_(tensor_of(folded.bias));
  layer.norm->running_mean.zero_();
  layer.norm->running_var.fill_(1 - layer.norm->options.eps());
  layer.adopts = true;
}

}  // namespace

Network unfolded(const pipeline::NetworkWeights& weights, const torch::Tensor& input, std::uint64_t seed) {
  NetworkShape shape;
  shape.stages = weights.stages;
  shape.pose = false;
  if (weights.fine_channels != shape.fine_channels ||
      !std::equal(shape.channels.begin(), shape.channels.end(), weights.unet_channels.begin(),
                  weights.unet_channels.end())) {
    throw InputError(fmt::format("{}: {}, {} channels: this program trains networks of {}, {}", printable(weights.file),
                                 weights.fine_channels, fmt::join(weights.unet_channels, " "), shape.fine_channels,
                                 fmt::join(shape.channels, " ")));
  }
  Network network = new_checkpoint(shape, seed).network;
  const torch::NoGradGuard no_gradients;
  const auto modules = network->named_modules();
  for (const auto& [name, folded] : weights.layers) {
    if (const auto layer = std::dynamic_pointer_cast<ConvImpl>(modules[name])) unfold(*layer, folded);
  }
  for (int s = 0; s < shape.stages; ++s) {
    torch::nn::Conv2d& sub_pixels = network->mask_heads[s]->sub_pixels;
    sub_pixels->weight.zero_();
    sub_pixels->bias.zero_();
  }
  const pipeline::ConvWeights& last = weights.layers.at(fmt::format("mask{}.sub_pixels", shape.stages - 1));
  torch::nn::Conv2d& sub_pixels = network->mask_heads.back()->sub_pixels;
  sub_pixels->weight.copy_(tensor_of(last.weight).view(sub_pixels->weight.sizes()));
  sub_pixels->bias.copy_(tensor_of(last.bias));

  network->eval();
  bool finite = torch::isfinite(network->forward(input, true).back().mask).all().item<bool>();
  for (const torch::Tensor& buffer : network->buffers()) finite = finite && torch::isfinite(buffer).all().item<bool>();
  if (!finite) throw InputError(printable(weights.file) + ": its weights give results that are not finite");
  for (const auto& item : modules) {
    if (const auto layer = std::dynamic_pointer_cast<ConvImpl>(item.value())) layer->adopts = false;
  }
  return network;
}

}  // namespace dualpixel::tools
