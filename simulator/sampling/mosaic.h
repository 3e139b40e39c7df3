#pragma once
#include "capture/color_filter_array.h"

namespace dualpixel::simulator {

/// The mosaic of every simulated sensor, as its captures name it.
inline constexpr const ColorFilterArray& kSimulatedCfa = kRggb;

/// Color filter of a photosite: 0 R, 1 G, 2 B.
constexpr int cfa_color(int x, int y) { return kSimulatedCfa.color(x, y); }

}  // namespace dualpixel::simulator
