#pragma once
#include "capture/image/image.h"

/// Resampling between the pipeline's resolutions. Corners stay aligned (capture/image/image.h): output x reads around
/// (x + 0.5) * in_width / out_width. Any number of channels, any positive sizes.
namespace dualpixel {

/// Each output pixel is the mean over the area that it covers: for reducing.
Image resize_area(const Image& image, int width, int height);

/// Bilinear interpolation between pixel centers, borders replicated: for enlarging.
Image resize_bilinear(const Image& image, int width, int height);

/// Where one output sample of resize_bilinear lies between two input samples.
struct LinearTap {
  int low = 0;
  int high = 0;
  float weight_of_high = 0;
};
LinearTap linear_tap(int out, int out_size, int in_size);

}  // namespace dualpixel
