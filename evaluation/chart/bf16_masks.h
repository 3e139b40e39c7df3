#pragma once
#include <vector>

#include "capture/image/image.h"
#include "evaluation/chart/chart_input.h"
#include "evaluation/chart/trials.h"

/// Person masks by the network in bf16, which a process that has run it in f32 cannot have (pipeline/segmentation/
/// network.h): another one, of `dualpixel experiment segmentation --bf16`, finds them.
namespace dualpixel::evaluation {

/// Puts a linear picture with its true mask into the scratch folder. Seeds are 1 and up.
void keep_for_bf16(const ChartInput& input, int seed, const Image& picture, const Image& true_mask);

/// What try_masks() calls "face found", of each picture that was kept; none where the processor cannot, or the chart
/// has no program to start.
std::vector<Trial> try_bf16(const ChartInput& input, int seeds);

}  // namespace dualpixel::evaluation
