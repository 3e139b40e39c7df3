#pragma once
#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"

namespace dualpixel::evaluation {

/// Whether the command `blender` is there, which measure_cycles() needs.
bool has_blender();

/// The renderer beside Blender's Cycles, on the same scene, by the input's script; without one, or where Blender or the
/// script fails, the reason alone.
ChartPart measure_cycles(const ChartInput& input);

}  // namespace dualpixel::evaluation
