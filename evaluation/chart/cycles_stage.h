#pragma once
#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"

namespace dualpixel::evaluation {

/// The renderer beside Blender's Cycles, on the same scene, by the input's script; without one, or where Blender or the
/// script fails, the reason alone.
ChartPart measure_cycles(const ChartInput& input);

}  // namespace dualpixel::evaluation
