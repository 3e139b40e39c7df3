#pragma once
#include "capture/image/image.h"

/// The data term of Barron et al. 2015, "Fast Bilateral-Space Stereo for Synthetic Defocus", section 4: not a cost for
/// each disparity, but the interval of disparities that explain a pixel.
namespace dualpixel::evaluation {

struct MatchIntervalOptions {
  int labels = 17;          ///< disparities that are tried: odd, 3 to 63, the middle one is 0
  int steps_per_dp_px = 8;  ///< of them in one DP px; the method's own is 1, too coarse for views of one lens
  float noise_levels = 4;   ///< of 255: intensities that lie so far apart may still be the same
  int window_columns = 5;   ///< DP px, odd: in so wide a window every pixel must match
  int window_rows = 3;      ///< DP px, odd

  float dp_px_of(float label) const {
    const int middle = labels / 2;
    return (label - static_cast<float>(middle)) / static_cast<float>(steps_per_dp_px);
  }
};

/// For each pixel the first and the last label that explains it, 0 to labels - 1; where none does, all of them: the
/// pixel says nothing.
struct MatchIntervals {
  Image first, last;
};

/// `left` and `right` are one channel, 0..255, encoded so that noise is about even (guide.h). Views are enlarged
/// horizontally, by cubic convolution, steps_per_dp_px times, so that each label shifts by a whole pixel of theirs. A
/// pixel matches at a label where the ranges of intensity half a pixel to either side overlap (Birchfield and Tomasi
/// 1998), widened by noise_levels; a label explains it where its whole window matches. What lies outside of the views
/// is as at their borders. Throws InputError where sizes differ or an option is out of its range.
MatchIntervals match_intervals(const Image& left, const Image& right, const MatchIntervalOptions& options = {});

}  // namespace dualpixel::evaluation
