#include "tools/train_segmentation/evaluate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tools/train_segmentation/batches.h"

namespace dualpixel::tools {
namespace {

constexpr std::size_t kScoredAtOnce = 16;
constexpr int kInnerDistance_px = static_cast<int>(0.05 * kNetworkSize_px + 0.5);

/// Calls `visit(first, predicted mask, true mask)` for batch after batch of `indices`.
template <typename Visit>
void for_each_batch(Network& network, const scenes::PeopleSet& set, const std::vector<std::size_t>& indices,
                    const std::function<void(double)>& progress, bool half_size, const Visit& visit) {
  const torch::NoGradGuard no_gradients;
  network->eval();
  const torch::Device device = network->parameters().front().device();
  for (std::size_t first = 0; first < indices.size(); first += kScoredAtOnce) {
    const std::size_t end = std::min(first + kScoredAtOnce, indices.size());
    Batch batch = on(device, plain_batch(set, {indices.begin() + first, indices.begin() + end}, false));
    if (half_size) batch = halved(batch);
    visit(first, network->forward(batch.input, true).back().mask.sigmoid(), batch.mask);
    if (progress) progress(static_cast<double>(end) / indices.size());
  }
}

}  // namespace

std::vector<MaskScore> evaluate(Network& network, const scenes::PeopleSet& set, const std::vector<std::size_t>& indices,
                                const std::function<void(double fraction)>& progress, bool half_size) {
  std::vector<MaskScore> scores;
  for_each_batch(network, set, indices, progress, half_size,
                 [&](std::size_t, const torch::Tensor& predicted, const torch::Tensor& truth) {
                   const torch::Tensor p = predicted > 0.5, t = truth > 0.5;
                   const torch::Tensor both = (p & t).sum({1, 2, 3}).to(torch::kFloat64);
                   const torch::Tensor either = (p | t).sum({1, 2, 3}).to(torch::kFloat64);
                   const torch::Tensor iou = torch::where(either > 0, both / either, torch::ones_like(both)).cpu();
                   const torch::Tensor error = predicted - truth;
                   const torch::Tensor dx = error.diff(1, 3), dy = error.diff(1, 2);
                   const torch::Tensor gradient = (dx.square().sum({1, 2, 3}) + dy.square().sum({1, 2, 3})).cpu();
                   const auto pixels = static_cast<double>(truth.size(2) * truth.size(3));
                   for (std::int64_t i = 0; i < iou.size(0); ++i) {
                     scores.push_back({iou[i].item<double>(), gradient[i].item<double>() / pixels});
                   }
                 });
  return scores;
}

MaskScore mean_of(const std::vector<MaskScore>& scores) {
  MaskScore sum;
  for (const MaskScore& score : scores) {
    sum.iou += score.iou;
    sum.gradient_error += score.gradient_error;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, scores.size()));
  return {sum.iou / count, sum.gradient_error / count};
}

torch::Tensor inner_errors_of(const torch::Tensor& predicted, const torch::Tensor& truth) {
  // A square of side 2 d + 1 for the disc of radius d: near an oblique outline it asks for a little more distance.
  const auto options =
      torch::nn::functional::MaxPool2dFuncOptions(2 * kInnerDistance_px + 1).stride(1).padding(kInnerDistance_px);
  const torch::Tensor outside = (truth <= 0.5).to(torch::kFloat32);
  const torch::Tensor inner = 1 - torch::nn::functional::max_pool2d(outside, options);
  const torch::Tensor error = ((predicted - truth).abs() * inner).sum({1, 2, 3});
  return error / inner.sum({1, 2, 3}).clamp_min(1);
}

std::vector<float> inner_errors(Network& network, const scenes::PeopleSet& set,
                                const std::function<void(double fraction)>& progress) {
  std::vector<std::size_t> all(set.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<float> errors(set.size());
  for_each_batch(network, set, all, progress, false,
                 [&](std::size_t first, const torch::Tensor& predicted, const torch::Tensor& truth) {
                   const torch::Tensor mean = inner_errors_of(predicted, truth).cpu().contiguous();
                   std::copy_n(mean.data_ptr<float>(), mean.numel(), errors.begin() + first);
                 });
  return errors;
}

}  // namespace dualpixel::tools
