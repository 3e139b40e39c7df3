#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/train_segmentation/network.h"

/// Training, phase one and two of Wadhwa et al. 2018, section 3.2.
///
/// Loss of each stage, added over the stages: cross-entropy of the mask, mean over pixels, plus 5 times that of the
/// heatmaps, mean over pixels and keypoints. In phase two the pose loss is left out, as in the paper, and half the soft
/// IoU loss is added, which is ours: a person far away has few pixels and so little weight in the cross-entropy, but as
/// much as any other in the score.
///
/// Where else it differs from the paper, since two cores for hours stand against 40 GPUs for a month: Adam with
/// decoupled weight decay, and one cycle of learning rates (up over the first twentieth, then down a cosine), which
/// reach in some ten thousand samples what constant steps need many times more for. `sgd` trains as the paper did.
namespace dualpixel::tools {

struct TrainOptions {
  std::vector<std::string> data, held_out;  ///< people sets
  std::string output;                       ///< the run's folder
  std::uint64_t samples = 0;                ///< to see in all; 0: as many as `hours` allows
  double hours = 0;                         ///< of training, its evaluations included; 0: as `samples` says
  bool resume = false;                      ///< from the folder's checkpoint
  NetworkShape shape;                       ///< of a network that starts untrained
  bool composites = true;                   ///< learn from people before other backgrounds, too
  /// Share of the training's time, its beginning, for pictures of half the side. The network is convolutions alone, and
  /// four times as many pictures in the same time teach it more (docs/segmentation.md).
  double half_size = 0.65;
  std::uint64_t seed = 1;
  torch::Device device = torch::kCPU;  ///< on another one, the same options need not give the same weights
  bool bf16 = false;  ///< convolutions in 16-bit floats, all else in f32: faster where the processor has AMX
  int threads = 0;    ///< 0: as many as there are cores
  /// Phase two: starts from this run's weights, or from a safetensors file's (unfold.h), without pose loss and without
  /// the samples that it is worst at; at full size throughout.
  std::string fine_tune;
  /// Stochastic gradient descent, at a rate of 0.1 and then of 1e-4, in either phase. The paper does not say when the
  /// rate fell: here it does for the last tenth.
  bool sgd = false;
  double rate = 0;             ///< the learning rate at its peak; 0: 3e-3, and 3e-4 in phase two; 0.1 with `sgd`
  double prune = 149.0 / 660;  ///< share of the samples, by largest inner error: as the paper's 660 k became 511 k
};

/// One minus the mean over the samples of a soft IoU, (sum p m + 8) / (sum (p + m - p m) + 8), for predicted masks p =
/// sigmoid(logits) and true masks m in 0..1. The 8 px limit the weight of samples in which little is visible. `logits`
/// and `mask` are (samples, 1, height, width).
torch::Tensor soft_iou_loss(const torch::Tensor& logits, const torch::Tensor& mask);

/// The share of a run's work that is done after `samples` of `total`. Samples in the first part of the run, up to
/// `half_size` of its work, are at half the side and cost a quarter.
double work_done(double samples, double total, double half_size);

/// Makes LibTorch ready; how many threads it uses. Throws InputError where it has not the device.
int ready_threads(const TrainOptions& options);

/// Throws InputError where the folder has the file, which runs leave; `advice` ends the message.
void require_no_run(const std::string& folder, const char* file, const char* advice);

/// Throws InputError where it cannot be made one.
void make_run_folder(const std::string& folder);

/// Of a clock that never goes back.
double now_s();

/// After the share `done` of a run.
double learning_rate(double done, double peak, bool sgd);

/// Writes to the output folder, again at every checkpoint (five minutes) and at the end, each file whole or not at all:
///   checkpoint.pt       what --resume continues from: weights, optimizer, samples seen
///   person.safetensors  for inference (export.h); not of the baseline
///   log.json            options, hashes of the data, and one entry for each checkpoint
///   chart.html          loss and held-out score
///   scores.csv          at the end alone: the score of each held-out sample, to compare runs sample by sample
/// Once `stop`, which is told how many samples it has seen, says so, it ends after a checkpoint. With `samples`, the
/// weights depend on the options, the data and the number of threads alone, however often the run was stopped and
/// resumed. Throws InputError for unusable data or weights, for a checkpoint of other options or data, and for weights
/// to start from that the run would write over.
void train(const TrainOptions& options, const std::function<bool(std::uint64_t samples)>& stop);

}  // namespace dualpixel::tools
