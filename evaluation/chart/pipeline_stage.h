#pragma once
#include <string>
#include <vector>

#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"

namespace dualpixel::evaluation {

/// The whole pipeline by mode and matcher, its portrait's error and its disparity's, by frames of the burst, and where
/// its error and time come from; defocus and person masks by themselves, on the same captures.
ChartPart measure_pipeline(const ChartInput& input);

/// How the time of mode dp+seg grows with the photosites, stage by stage; the memory of the whole, and the simulator's.
ChartPart measure_pipeline_growth(const ChartInput& input);

/// The folder of one of the captures that measure_pipeline() works on, of seed 1 and up, in the scratch folder;
/// rendered where no stage has asked for it yet.
std::string chart_capture(const ChartInput& input, int seed);

}  // namespace dualpixel::evaluation
