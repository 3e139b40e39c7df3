#pragma once
#include <string>
#include <vector>

#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"

namespace dualpixel::evaluation {

/// The whole pipeline by mode and matcher, its portrait's error and its disparity's, and by frames of the burst.
std::vector<ChartSection> measure_pipeline(const ChartInput& input);

/// Writes the first of the captures that measure_pipeline() works on into the scratch folder; its path.
std::string write_chart_capture(const ChartInput& input);

}  // namespace dualpixel::evaluation
