#pragma once
#include "capture/image/image.h"

/// Smooth horizontal flow between the views of a surface without depth edges: a calibration target (Wadhwa et al. 2018,
/// supplement, "Disparity of Calibration Data": the optical flow of Liu 2009 with horizontal motion alone, an L1 data
/// term and an L2 smoothness term, after normalizing the views for lens shading).
namespace dualpixel::pipeline {

struct FlowOptions {
  /// The views are first averaged over blocks of this many DP pixels. Coarse on purpose: the mirrored kernels of the
  /// two views match at their centroids only where the texture is coarse against the blur (finer texture gives up to 12
  /// % too much disparity), and averaging reduces noise.
  int block_width_px = 4;
  int block_height_px = 2;
  int window_blocks = 33;  ///< normalization window, blocks a side, odd; the paper's 9 px are those of its matcher, and
                           ///< on blocks so coarse nine would take out the very texture that kernels agree on
  float charbonnier = 0.1f;  ///< difference at which the data term turns from square to linear, in local deviations
  float smooth_blocks = 8;   ///< distance over which the flow is smoothed where texture is average, blocks
  int warps = 4;             ///< linearizations a level
  int refinements = 3;       ///< repetitions with both views brought to the same light, 1 or more
  int sweeps = 40;           ///< over-relaxation sweeps a linearization (Liu 2009: 30 and more)
};

/// One pixel a block: ceil(size / block).
struct Flow {
  Image disparity_dp_px;  ///< d with right(x + d) = left(x), always finite
  /// Squared difference of the matched, normalized views: 0 where they agree, 2 where nothing fits or nothing is seen.
  Image mismatch;
};

/// `left` and `right` are linear views of one size. Minimizes over d
///     sum sqrt((right(x + d) - left(x))^2 + charbonnier^2) + lambda sum |grad d|^2
/// over the normalized blocks, coarse to fine on a pyramid of halved sizes, with `warps` linearizations a level. lambda
/// is smooth_blocks^2 times the mean curvature of the data term, so that the smoothness does not depend on contrast and
/// noise.
///
/// This is done once, and then `refinements` times more. Each repetition first moves the right view by the flow so far,
/// so that normalization windows that the border cuts short show the same part of the target in both views. It also
/// scales the right view to the left view's light by a smooth fit of their ratio, a polynomial of degree 8 or less;
/// where the views match, that ratio holds shading but no texture.
///
/// The same bytes for any number of threads. Throws InputError where the views differ in size, are empty or have more
/// than one channel, and where an option is not positive.
Flow match_target(const Image& left, const Image& right, const FlowOptions& options = {});

}  // namespace dualpixel::pipeline
