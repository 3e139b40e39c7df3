#pragma once
#include <torch/torch.h>

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/train_segmentation/network.h"

/// What an interrupted training run resumes from, and a fine-tuning run starts from.
namespace dualpixel::tools {

struct Checkpoint {
  Network network{nullptr};
  bool sgd = false;  ///< the optimizer: stochastic gradient descent, else Adam with decoupled weight decay
  std::unique_ptr<torch::optim::Optimizer> optimizer;
  std::uint64_t samples = 0;                                        ///< seen
  double seconds = 0;                                               ///< of training
  nlohmann::ordered_json recipe;                                    ///< what the weights depend on
  nlohmann::ordered_json points = nlohmann::ordered_json::array();  ///< the log's
};

/// Untrained, of the seed's weights.
Checkpoint new_checkpoint(const NetworkShape& shape, std::uint64_t seed);

/// Keeps the network's weights and starts the optimizer afresh, without the moments of earlier steps.
void forget_optimizer(Checkpoint& checkpoint);

/// Of all numbers that a network holds.
std::string weights_hash(Network& network);

void write_checkpoint(const Checkpoint& checkpoint, const std::string& path);

/// Into the memory of `device`. Throws InputError for what is not a checkpoint, and for a damaged one.
Checkpoint read_checkpoint(const std::string& path, torch::Device device = torch::kCPU);

}  // namespace dualpixel::tools
