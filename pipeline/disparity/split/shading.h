#pragma once
#include "capture/image/image.h"

namespace dualpixel::pipeline::split {

/// A lens dims one view more than the other towards the sides. Multiplies the views, of one size, by exp(-q / 2) and
/// exp(q / 2), q being the linear function of the position that leaves the least squares of their difference; samples
/// brighter than most are compared relative to their own light. Unlike the ratio of means over a window, it holds up to
/// the border; higher powers would take disparity for shading in small pictures. Samples are finite.
void even_out_shading(Image& left, Image& right);

}  // namespace dualpixel::pipeline::split
