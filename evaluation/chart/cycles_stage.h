#pragma once
#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"

namespace dualpixel::evaluation {

inline constexpr char kCyclesScript[] = "tools/compare_cycles.py";

/// Whether Blender and the script are there.
bool can_measure_cycles();

/// The renderer beside Blender's Cycles, on the same scene, by the script; nothing where they are not there, or end
/// with an error.
ChartPart measure_cycles(const ChartInput& input);

}  // namespace dualpixel::evaluation
