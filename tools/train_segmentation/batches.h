#pragma once
#include <torch/torch.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "scenes/people/data_set/read_people_set.h"

/// Batches for the network.
namespace dualpixel::tools {

/// In the network's shapes (network.h), channels last in memory.
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

/// Shuffled and augmented samples without end, made ahead by a thread of its own. The n-th sample of a seed is always
/// the same one, varied in the same way: every sample once in each pass over `kept`, in an order of that pass's own.
class AugmentedBatches {
 public:
  AugmentedBatches(const scenes::PeopleSet& set, std::vector<std::size_t> kept, int batch_size, bool heatmaps,
                   std::uint64_t seed, std::uint64_t first_sample);
  ~AugmentedBatches();
  Batch next();

 private:
  void produce();
  Batch make();

  const scenes::PeopleSet& set_;
  std::vector<std::size_t> kept_;
  int batch_size_;
  bool heatmaps_;
  std::uint64_t seed_, sample_;
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
