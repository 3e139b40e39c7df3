#pragma once
#include <optional>
#include <vector>

#include "evaluation/benchmarks/smoothing_method.h"

/// Filters of OpenCV's ximgproc; nothing where the build has none (DUALPIXEL_XIMGPROC).
namespace dualpixel::evaluation {

/// Its fast bilateral solver with the grid's cells, lambda 128 and 25 iterations.
std::optional<Image> solve_with_opencv(const SmoothingInput& input, const pipeline::BilateralGridOptions& cells);

/// The solver at several sizes, guided filter, fast global smoother, domain transform; without the median.
std::vector<SmoothingMethod> opencv_smoothing_methods();

}  // namespace dualpixel::evaluation
