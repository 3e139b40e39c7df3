#pragma once
#include <torch/torch.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "scenes/people/data_set/read_people_set.h"

/// Batches for the network.
namespace dualpixel::tools {

/// In the network's shapes (network.h), channels last in memory. Of a face detector (face_examples.h): without mask,
/// and with its targets as heatmaps.
struct Batch {
  torch::Tensor input, mask;
  torch::Tensor heatmaps;  ///< undefined where not asked for
};

/// In the memory of `device`.
Batch on(torch::Device device, const Batch& batch);

/// At half the size: means of 2 x 2.
Batch halved(const Batch& batch);

/// The given samples as they are.
Batch plain_batch(const scenes::PeopleSet& set, const std::vector<std::size_t>& indices, bool heatmaps);

/// One varied example: the index of what it is made from, and the key of all that is drawn for it.
struct Draw {
  std::size_t index;
  std::uint64_t key;
};

/// Samples of a set, varied by draw_augmentation().
Batch augmented_batch(const scenes::PeopleSet& set, const std::vector<Draw>& draws, bool heatmaps);

/// Shuffled and augmented examples without end, made ahead by a thread of its own. The n-th of a seed is always the
/// same one, varied in the same way: every one of `kept` once in each pass over them, in an order of that pass's own.
class AugmentedBatches {
 public:
  using Make = std::function<Batch(const std::vector<Draw>&)>;
  AugmentedBatches(std::vector<std::size_t> kept, int batch_size, std::uint64_t seed, std::uint64_t first_sample,
                   Make make);
  ~AugmentedBatches();
  Batch next();

 private:
  void produce();
  std::vector<Draw> next_draws();

  std::vector<std::size_t> kept_;
  int batch_size_;
  std::uint64_t seed_, sample_;
  Make make_;
  std::uint64_t shuffled_pass_ = ~std::uint64_t{0};
  std::vector<std::size_t> order_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Batch> ready_;
  std::exception_ptr failure_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace dualpixel::tools
