#pragma once
#include <array>

#include "capture/names.h"

namespace dualpixel {

/// The mosaic of color filters over a sensor: it repeats every 2 x 2 photosites.
struct ColorFilterArray {
  std::array<int, 4> colors;  ///< 0 R, 1 G, 2 B; of the top-left 2 x 2 photosites, row by row

  constexpr int color(int x, int y) const { return colors[2 * (y & 1) + (x & 1)]; }
  bool operator==(const ColorFilterArray&) const = default;
};

inline constexpr ColorFilterArray kRggb{{0, 1, 1, 2}};

/// As captures name them (Camera::cfa).
inline constexpr Named<ColorFilterArray> kColorFilterArrays[] = {
    {"RGGB", kRggb, "red in the top-left corner"},
    {"BGGR", {{2, 1, 1, 0}}, "blue in the top-left corner"},
    {"GRBG", {{1, 0, 2, 1}}, "green in the top-left corner, red beside it"},
    {"GBRG", {{1, 2, 0, 1}}, "green in the top-left corner, blue beside it"},
};

}  // namespace dualpixel
