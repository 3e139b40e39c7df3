#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// A picture with synthetic defocus, and what was done to it; all of the picture's size.
struct Defocused {
  Image rgb;        ///< linear
  Image blurred;    ///< 0..1: share of a pixel that comes from blurred layers; 0: the input's pixel
  Image radius_px;  ///< full-resolution px; empty from render_defocus, which is given it
};

}  // namespace dualpixel::pipeline
