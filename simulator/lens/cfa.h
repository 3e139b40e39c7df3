#pragma once

namespace dualpixel::simulator {

/// Colour filter of a photosite (0 R, 1 G, 2 B) in an RGGB mosaic.
constexpr int cfa_color(int x, int y) { return (x & 1) + (y & 1); }

}  // namespace dualpixel::simulator
