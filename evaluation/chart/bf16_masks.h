#pragma once
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "evaluation/chart/chart_input.h"
#include "evaluation/chart/trials.h"

/// Person masks by the network in bf16. A process that has run it in f32 cannot (network.h); another one, `dualpixel
/// experiment segmentation --bf16`, does.
namespace dualpixel::evaluation {

/// Puts a linear picture with its true mask into the scratch folder. Seeds are 1 and up.
void keep_for_bf16(const ChartInput& input, int seed, const Image& picture, const Image& true_mask);

struct Bf16Masks {
  std::vector<Trial> trials;  ///< what try_masks() calls "face found", of each picture that was kept
  std::string left_out;       ///< why there are none
};
Bf16Masks try_bf16(const ChartInput& input, int seeds);

}  // namespace dualpixel::evaluation
