#include "tools/train_segmentation/batches.h"

#include <utility>

#include "simulator/sampling/hash.h"
#include "tools/train_segmentation/augment.h"
#include "tools/train_segmentation/network.h"

namespace dualpixel::tools {
namespace {

constexpr std::size_t kBatchesAhead = 4;

/// Buffers laid out channels last, and tensors that view them in the network's order of dimensions.
struct Buffers {
  Buffers(std::int64_t count, bool with_heatmaps)
      : input(torch::empty({count, kNetworkSize_px, kNetworkSize_px, 4})),
        mask(torch::empty({count, 1, kNetworkSize_px, kNetworkSize_px})) {
    if (with_heatmaps) heatmaps = torch::empty({count, kHeatmapSize_px, kHeatmapSize_px, scenes::kKeypoints});
  }
  void fill(std::int64_t i, const scenes::PersonSample& sample, const Augmentation& augmentation) {
    make_example(sample, augmentation, input[i].data_ptr<float>(), mask[i].data_ptr<float>(),
                 heatmaps.defined() ? heatmaps[i].data_ptr<float>() : nullptr);
  }
  Batch batch() const {
    return {input.permute({0, 3, 1, 2}), mask, heatmaps.defined() ? heatmaps.permute({0, 3, 1, 2}) : heatmaps};
  }

  torch::Tensor input, mask, heatmaps;
};

}  // namespace

Batch on(torch::Device device, const Batch& batch) {
  const auto there = [&](const torch::Tensor& tensor) { return tensor.defined() ? tensor.to(device) : tensor; };
  return {there(batch.input), there(batch.mask), there(batch.heatmaps)};
}

Batch halved(const Batch& batch) {
  return {torch::avg_pool2d(batch.input, 2), torch::avg_pool2d(batch.mask, 2),
          batch.heatmaps.defined() ? torch::avg_pool2d(batch.heatmaps, 2) : batch.heatmaps};
}

Batch plain_batch(const scenes::PeopleSet& set, const std::vector<std::size_t>& indices, bool heatmaps) {
  Buffers buffers(static_cast<std::int64_t>(indices.size()), heatmaps);
  for (std::size_t i = 0; i < indices.size(); ++i) buffers.fill(static_cast<std::int64_t>(i), set[indices[i]], {});
  return buffers.batch();
}

Batch augmented_batch(const scenes::PeopleSet& set, const std::vector<Draw>& draws, bool heatmaps) {
  Buffers buffers(static_cast<std::int64_t>(draws.size()), heatmaps);
  for (std::size_t i = 0; i < draws.size(); ++i) {
    buffers.fill(static_cast<std::int64_t>(i), set[draws[i].index], draw_augmentation(draws[i].key));
  }
  return buffers.batch();
}

AugmentedBatches::AugmentedBatches(std::vector<std::size_t> kept, int batch_size, std::uint64_t seed,
                                   std::uint64_t first_sample, Make make)
    : kept_(std::move(kept)),
      batch_size_(batch_size),
      seed_(seed),
      sample_(first_sample),
      make_(std::move(make)),
      thread_([this] { produce(); }) {}

AugmentedBatches::~AugmentedBatches() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::vector<Draw> AugmentedBatches::next_draws() {
  std::vector<Draw> draws;
  for (int i = 0; i < batch_size_; ++i, ++sample_) {
    const std::uint64_t pass = sample_ / kept_.size();
    if (pass != shuffled_pass_) {
      order_ = kept_;
      for (std::size_t k = order_.size(); k > 1; --k) {
        std::swap(order_[k - 1], order_[simulator::hash(seed_, pass, k) % k]);
      }
      shuffled_pass_ = pass;
    }
    draws.push_back({order_[sample_ % kept_.size()], simulator::hash(seed_, sample_)});
  }
  return draws;
}

void AugmentedBatches::produce() {
  try {
    while (true) {
      Batch batch = make_(next_draws());
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || ready_.size() < kBatchesAhead; });
      if (ending_) return;
      ready_.push_back(std::move(batch));
      changed_.notify_all();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    changed_.notify_all();
  }
}

Batch AugmentedBatches::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || !ready_.empty(); });
  if (ready_.empty()) std::rethrow_exception(failure_);
  Batch batch = std::move(ready_.front());
  ready_.pop_front();
  changed_.notify_all();
  return batch;
}

}  // namespace dualpixel::tools
