#include "tools/train_segmentation/network.h"

#include <cmath>

namespace dualpixel::tools {
namespace {

torch::Tensor twice_as_large(const torch::Tensor& x) {
  namespace F = torch::nn::functional;
  return F::interpolate(x, F::InterpolateFuncOptions().scale_factor(std::vector<double>{2, 2}).mode(torch::kNearest));
}

}  // namespace

NetworkShape face_network_shape() {
  NetworkShape shape;
  shape.faces = true;
  shape.stages = 1;
  shape.pose = false;
  shape.fine_channels = 16;
  shape.channels = {32, 48, 64, 64};
  return shape;
}

ConvImpl::ConvImpl(int in, int out, int kernel, int stride, bool relu_) : relu(relu_) {
  const auto options = torch::nn::Conv2dOptions(in, out, kernel).stride(stride).padding(kernel / 2).bias(false);
  conv = register_module("conv", torch::nn::Conv2d(options));
  torch::nn::init::kaiming_normal_(conv->weight, 0, torch::kFanIn, torch::kReLU);
  norm = register_module("norm", torch::nn::BatchNorm2d(out));
}

torch::Tensor ConvImpl::forward(const torch::Tensor& x) {
  const torch::Tensor z = conv(x);
  if (adopts) adopt_statistics(z);
  torch::Tensor y = norm(z);
  return relu ? y.relu_() : y;
}

void ConvImpl::adopt_statistics(const torch::Tensor& z) {
  const torch::NoGradGuard no_gradients;
  const torch::Tensor mean = z.mean({0, 2, 3}), variance = z.var({0, 2, 3}, false);
  const double eps = norm->options.eps();
  const torch::Tensor slope = norm->weight / (norm->running_var + eps).sqrt();
  norm->bias.add_(slope * (mean - norm->running_mean));
  norm->weight.copy_(slope * (variance + eps).sqrt());
  norm->running_mean.copy_(mean);
  norm->running_var.copy_(variance);
}

UNetImpl::UNetImpl(const NetworkShape& shape) {
  const auto& c = shape.channels;
  const int deepest = static_cast<int>(c.size()) - 1;
  for (int level = 0; level <= deepest; ++level) {
    const std::string n = std::to_string(level);
    if (level > 0) down.push_back(register_module("down" + n, Conv(c[level - 1], c[level], 3, 2, true)));
    across.push_back(register_module("across" + n, Conv(c[level], c[level], 3, 1, true)));
    if (level == deepest) break;
    lateral.push_back(register_module("lateral" + n, Conv(c[level + 1], c[level], 1, 1, false)));
    up.push_back(register_module("up" + n, Conv(c[level], c[level], 3, 1, true)));
  }
}

torch::Tensor UNetImpl::forward(torch::Tensor x) {
  std::vector<torch::Tensor> skips;
  for (std::size_t level = 0; level < across.size(); ++level) {
    if (level > 0) x = down[level - 1](x);
    x = across[level](x);
    skips.push_back(x);
  }
  for (int level = static_cast<int>(up.size()) - 1; level >= 0; --level) {
    x = up[level]((skips[level] + twice_as_large(lateral[level](x))).relu_());
  }
  return x;
}

MaskHeadImpl::MaskHeadImpl(const NetworkShape& shape) {
  coarse = register_module("coarse", Conv(shape.channels[0], shape.fine_channels, 1, 1, false));
  mix = register_module("mix", Conv(shape.fine_channels, shape.fine_channels, 3, 1, true));
  sub_pixels =
      register_module("sub_pixels", torch::nn::Conv2d(torch::nn::Conv2dOptions(shape.fine_channels, 4, 3).padding(1)));
}

torch::Tensor MaskHeadImpl::forward(const torch::Tensor& features, const torch::Tensor& fine) {
  const torch::Tensor x = (fine + twice_as_large(coarse(features))).relu_();
  return torch::pixel_shuffle(sub_pixels(mix(x)), 2);
}

FcnImpl::FcnImpl() {
  constexpr std::array<int, 6> kChannels = {4, 16, 48, 96, 160, 256};
  for (int level = 1; level < static_cast<int>(kChannels.size()); ++level) {
    const std::string n = std::to_string(level);
    const int in = kChannels[level - 1], out = kChannels[level];
    down.push_back(register_module("down" + n, Conv(in, out, 3, 2, true)));
    across.push_back(register_module("across" + n, Conv(out, out, 3, 1, true)));
    if (level < 3) continue;  // finer than 1/8
    votes.push_back(register_module("vote" + n, torch::nn::Conv2d(torch::nn::Conv2dOptions(out, 1, 1))));
  }
}

torch::Tensor FcnImpl::forward(torch::Tensor x) {
  namespace F = torch::nn::functional;
  const auto enlarged = [](const torch::Tensor& map, double by) {
    return F::interpolate(map, F::InterpolateFuncOptions()
                                   .scale_factor(std::vector<double>{by, by})
                                   .mode(torch::kBilinear)
                                   .align_corners(false));
  };
  std::vector<torch::Tensor> scores;
  for (std::size_t level = 0; level < down.size(); ++level) {
    x = across[level](down[level](x));
    if (level >= 2) scores.push_back(votes[level - 2](x));
  }
  return enlarged(scores[0] + enlarged(scores[1] + enlarged(scores[2], 2), 2), 8);
}

NetworkImpl::NetworkImpl(const NetworkShape& shape_) : shape(shape_) {
  if (shape.fcn) {
    fcn = register_module("fcn", Fcn());
    return;
  }
  const int fine = shape.fine_channels, wide = shape.channels[0];
  stem_half = register_module("stem_half", Conv(shape.faces ? 3 : 4, fine, 3, 2, true));
  stem_fine = register_module("stem_fine", Conv(fine, fine, 3, 1, true));
  stem_quarter = register_module("stem_quarter", Conv(fine, wide, 3, 2, true));
  for (int s = 0; s < shape.stages; ++s) {
    const std::string n = std::to_string(s);
    stages.push_back(register_module("stage" + n, UNet(shape)));
    if (shape.faces) continue;
    mask_heads.push_back(register_module("mask" + n, MaskHead(shape)));
    if (s + 1 < shape.stages) between.push_back(register_module("between" + n, Conv(wide, wide, 1, 1, false)));
    if (!shape.pose) continue;
    pose_heads.push_back(
        register_module("pose" + n, torch::nn::Conv2d(torch::nn::Conv2dOptions(wide, scenes::kKeypoints, 1))));
    // Heatmaps are black nearly everywhere: start there, so that the pose loss does not swamp the mask's.
    torch::nn::init::constant_(pose_heads.back()->bias, -5);
  }
  if (!shape.faces) return;
  face_head = register_module("face_map", torch::nn::Conv2d(torch::nn::Conv2dOptions(wide, 4, 3).padding(1)));
  const torch::NoGradGuard no_gradients;
  face_head->bias[0] = -5;  // nearly no cell is a face's center
}

torch::Tensor NetworkImpl::face_map(const torch::Tensor& input) {
  return face_head(stages[0](stem_quarter(stem_fine(stem_half(input)))));
}

std::vector<StageOutput> NetworkImpl::forward(const torch::Tensor& input, bool last_only) {
  if (shape.fcn) return {{fcn(input), {}}};
  const torch::Tensor fine = stem_fine(stem_half(input));
  torch::Tensor x = stem_quarter(fine);
  std::vector<StageOutput> outputs;
  for (int s = 0; s < shape.stages; ++s) {
    const torch::Tensor features = stages[s](x);
    const bool last = s + 1 == shape.stages;
    if (last || !last_only) {
      outputs.push_back({mask_heads[s](features, fine), shape.pose ? pose_heads[s](features) : torch::Tensor()});
    }
    if (!last) x = (x + between[s](features)).relu_();
  }
  return outputs;
}

}  // namespace dualpixel::tools
