#pragma once
#include <torch/torch.h>

#include <array>
#include <string>
#include <vector>

#include "scenes/people/data_set/people_format.h"

/// The person segmentation network of Wadhwa et al. 2018, section 3.2, as LibTorch trains it: three stacked U-Nets
/// with a mask and 17 keypoint heatmaps after each.
///
/// Input, (batch, 4, 256, 256): sRGB in 0..1 minus 0.5, and a Gaussian of sigma 21 px and peak 1 on the seed's face.
/// The paper gives no widths or depths; ours are chosen for one processor core:
///   stem     two strided convolutions to 64 x 64, with a "fine" map of 128 x 128 between them
///   U-Net    four levels, 64 to 8 px; skips are added, not concatenated (the same map followed by a narrower kernel)
///   between  a stage's features, through a 1 x 1 kernel, are added to what it was given. Newell et al. 2016 also feed
///            the predictions back; heatmaps are a linear map of those features, so that says the same
///   mask     features at 64 x 64, enlarged and added to the fine map, convolved at 128 x 128, four sub-pixels each
/// Every convolution but the heads' last is followed by batch normalization, which export folds into its kernel.
namespace dualpixel::tools {

inline constexpr int kNetworkSize_px = scenes::kPictureSide_px;
inline constexpr int kHeatmapSize_px = kNetworkSize_px / 4;

struct NetworkShape {
  /// A baseline in place of the U-Nets, of one stage and without pose: layers to 1/32 of the size, of which those at
  /// 1/8, 1/16 and 1/32 vote on the mask (FCN-8 of Long et al. 2015, as the portraits of Shen et al. 2016 had it).
  bool fcn = false;
  /// The face detector (pipeline/segmentation/face_network.h) in place of masks: one stage, without pose and without
  /// the seed's channel; its head is a map of four channels at 64 x 64.
  bool faces = false;
  int stages = 3;
  bool pose = true;  ///< heatmaps after each stage; they cost nothing at inference
  int fine_channels = 16;
  std::array<int, 4> channels = {32, 64, 96, 64};  ///< at 64, 32, 16 and 8 px
};

/// Small enough for a few milliseconds of one core and 540 kB.
NetworkShape face_network_shape();

/// Convolution (odd kernel, padded to keep the size), batch normalization, and ReLU where asked for.
struct ConvImpl : torch::nn::Module {
  ConvImpl(int in, int out, int kernel, int stride, bool relu);
  torch::Tensor forward(const torch::Tensor& x);
  /// Makes the normalization's statistics those of the convolution's results `z`; in evaluation, the layer's results
  /// stay as they were.
  void adopt_statistics(const torch::Tensor& z);

  torch::nn::Conv2d conv{nullptr};
  torch::nn::BatchNorm2d norm{nullptr};
  bool relu;
  bool adopts = false;  ///< forward() adopts the statistics of what it sees
};
TORCH_MODULE(Conv);

struct UNetImpl : torch::nn::Module {
  explicit UNetImpl(const NetworkShape& shape);
  torch::Tensor forward(torch::Tensor x);

  std::vector<Conv> down, across, lateral, up;
};
TORCH_MODULE(UNet);

struct MaskHeadImpl : torch::nn::Module {
  explicit MaskHeadImpl(const NetworkShape& shape);
  torch::Tensor forward(const torch::Tensor& features, const torch::Tensor& fine);

  Conv coarse{nullptr}, mix{nullptr};
  torch::nn::Conv2d sub_pixels{nullptr};
};
TORCH_MODULE(MaskHead);

/// Logits: the sigmoid is left to the loss, and to inference.
struct StageOutput {
  torch::Tensor mask;      ///< (batch, 1, 256, 256)
  torch::Tensor heatmaps;  ///< (batch, 17, 64, 64); undefined where the network has no pose
};

struct FcnImpl : torch::nn::Module {
  FcnImpl();
  torch::Tensor forward(torch::Tensor x);

  std::vector<Conv> down, across;
  std::vector<torch::nn::Conv2d> votes;
};
TORCH_MODULE(Fcn);

struct NetworkImpl : torch::nn::Module {
  explicit NetworkImpl(const NetworkShape& shape);
  /// One output a stage; the last alone where `last_only`.
  std::vector<StageOutput> forward(const torch::Tensor& input, bool last_only = false);

  NetworkShape shape;
  /// Of a face detector: (batch, 4, height / 4, width / 4); the score is a logit.
  torch::Tensor face_map(const torch::Tensor& input);

  Fcn fcn{nullptr};  ///< where the shape asks for it; then there is nothing else
  Conv stem_half{nullptr}, stem_fine{nullptr}, stem_quarter{nullptr};
  std::vector<UNet> stages;
  std::vector<Conv> between;
  std::vector<MaskHead> mask_heads;
  std::vector<torch::nn::Conv2d> pose_heads;
  torch::nn::Conv2d face_head{nullptr};
};
TORCH_MODULE(Network);

}  // namespace dualpixel::tools
