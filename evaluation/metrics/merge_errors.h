#pragma once
#include "capture/capture.h"
#include "pipeline/burst/merge.h"

namespace dualpixel::evaluation {

/// A merged burst against what its base frame would have shown without noise: differences of signals over white.
struct MergeErrors {
  Image left, right, mosaic;

  double views_rms() const;   ///< but for a border, where windows and tiles are cut short
  double mosaic_rms() const;  ///< likewise
  /// Share of squares of 4 x 4 DP px whose mean is off by more than `limit`.
  double squares_beyond(double limit) const;
};

/// `capture` has truth: that of the frame which the merged pictures should show. Its sensor is RGGB.
MergeErrors merge_errors(const pipeline::MergedBurst& merged, const Capture& capture);

/// The first frame, not merged at all.
pipeline::MergedBurst first_frame(const Capture& capture);

}  // namespace dualpixel::evaluation
