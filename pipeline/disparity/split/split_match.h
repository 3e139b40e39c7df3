#pragma once
#include "capture/image/image.h"
#include "pipeline/disparity/likelihood/options.h"
#include "pipeline/disparity/split/options.h"
#include "pipeline/disparity/tile_disparity.h"

/// Disparity of every tile, also where blur is strong. Blurred through a soft split, two views are no shift of each
/// other above some 0.2 / |d| cycles a pixel: the phase between them follows their kernels and even turns its sign.
/// This matcher knows the kernels of each disparity, for soft splits and hard ones.
namespace dualpixel::pipeline {

/// `left` and `right` are linear views of one size, one channel, normalized signal. Returns d with right(x + d) =
/// left(x), of the kernels' centroids, for each 8 x 8 tile. Steps:
///   1. Both views under a Gaussian, at a quarter of their size; their ratio taken out, first as a linear function
///      of the position (shading.h), then over a wide window; local means taken out; divided by the local contrast, so
///      that no edge outweighs its surroundings. Beyond the left and right border the views change places.
///   2. For every whole |d| up to the range, blur b = d / alpha: left through the right view's kernel less
///      right through the left's, whitened (split_filters.h), both as flat as the pixels are high. Squares are summed
///      over a Gaussian window, in which what has over .3 of the mean square contrast of its surroundings is weighted
///      by the inverse: highlights and the outlines of near things would answer for all around them.
///   3. Between hypotheses the residual is taken as linear in d, and its least square found.
///   4. Near the focus, where blur is narrow and fine texture tells more, the likelihood matcher is asked, given
///      `near_focus` with a range just wide enough. Where both answers lie under near_focus_dp_px, its answer. Where
///      only the answer of step 3 does, and the likelihood matcher's excludes it, or the focus, by two standard
///      deviations, again the likelihood matcher's, with half of their distance in sigma: its narrower windows do not
///      reach over a depth edge. Else that of step 3, with the larger sigma: nothing, where the likelihood matcher sees
///      nothing. Where step 3's lies beyond it by less than two standard deviations, it may be chance. It is kept as
///      it is where the likelihood matcher's agrees (within two joint standard deviations), lies beyond the limit on
///      the same side, and excludes 0 by two of its own. Otherwise: the likelihood matcher's answer, if that lies
///      under near_focus_dp_px and within two standard deviations of step 3's, with their distance in sigma; or step
///      3's, with its distance from 0 in sigma.
///
/// sigma_dp_px is the predicted standard deviation of the error, at most range_px; away from the focus root-sum-square
/// of the least residual over its sensitivity to d, for six independent samples a window, fewer where parts of it clip
/// or weigh more than the rest; the spread of other disparities that the residuals cannot rule out; and 0.04 |d|, or
/// 0.02 |d| where alpha is known, for kernels that are not quite the camera's.
/// Confidence is 1 / (1 + (sigma / confident_sigma_dp_px)^2), and 0 where nothing is known: there sigma is range_px, as
/// where step 3's best disparity is an end of the range.
/// `shared` is 0.9 there, as windows overlap.
///
/// Pixels that are clipped or not finite in either view are left out; empty views give an empty answer. The answer does
/// not depend on the number of threads. Throws InputError where the views' sizes differ, they have more than one
/// channel, or an option is out of range.
TileDisparity match_by_split(const Image& left, const Image& right, const SplitMatchOptions& options = {},
                             const LikelihoodMatchOptions& near_focus = {});

}  // namespace dualpixel::pipeline
