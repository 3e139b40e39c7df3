#pragma once
#include <torch/torch.h>

#include <cstddef>
#include <functional>
#include <vector>

#include "scenes/people/data_set/read_people_set.h"
#include "tools/train_segmentation/network.h"

/// How good a network's masks are.
namespace dualpixel::tools {

struct MaskScore {
  double iou = 0;             ///< intersection over union, both masks cut at 0.5
  double gradient_error = 0;  ///< E[(grad M^ - grad M)^2]: forward differences along x and y, squared and added, mean
                              ///< over pixels
};

/// One score for each of `indices`, on samples as they are, or at half their size. `network` is left in evaluation
/// mode.
std::vector<MaskScore> evaluate(Network& network, const scenes::PeopleSet& set, const std::vector<std::size_t>& indices,
                                const std::function<void(double fraction)>& progress = {}, bool half_size = false);

/// Zeros of none.
MaskScore mean_of(const std::vector<MaskScore>& scores);

/// Each mask's mean |M^ - M| inside: over pixels in the person and at least 0.05 of the picture's side away from its
/// outline (the distance is in the source of Wadhwa et al. 2018, section 3.2); 0 where there are none. Both
/// (batch, 1, 256, 256).
torch::Tensor inner_errors_of(const torch::Tensor& predicted, const torch::Tensor& truth);

/// Those of a network's masks of all samples.
std::vector<float> inner_errors(Network& network, const scenes::PeopleSet& set,
                                const std::function<void(double fraction)>& progress = {});

}  // namespace dualpixel::tools
