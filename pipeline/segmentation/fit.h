#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// A linear picture scaled, keeping its shape, to `longer_side_px` on its longer side (the other is at least 1 px), as
/// means over areas where it shrinks. A single channel becomes three; values are clipped to 0..1, as a camera would,
/// before they mix, and NaN becomes 0.
Image fitted(const Image& linear, int longer_side_px);

/// What a network sees of a picture: that which is fitted to a square, in sRGB minus 0.5, in the middle of it.
struct Framed {
  Image square;                  ///< -0.5 beside the picture, and in channels beyond its three
  int left, top, width, height;  ///< of the picture in it
};
Framed framed(const Image& linear, int side_px, int channels);

}  // namespace dualpixel::pipeline
