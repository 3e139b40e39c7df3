#pragma once
#include "capture/image/image.h"
#include "pipeline/disparity/likelihood/options.h"
#include "pipeline/disparity/tile_disparity.h"

/// Disparity of every tile by maximum likelihood, with the error that it is likely to have: beside the paper's method
/// (match.h), for views as they are, not normalized.
namespace dualpixel::pipeline {

/// `left` and `right` are linear views of one size, one channel, normalized signal. Returns d with right(x + d) =
/// left(x) for each 8 x 8 tile, both views sampled half the shift away from it: right(x + d/2) = left(x - d/2), so that
/// mirrored kernels pull equally. Steps:
///   1. The ratio of local means, over a tenth of the picture's width, takes lens shading out of both views evenly.
///   2. All whole shifts, on views smoothed by 1/4 1/2 1/4: squared difference over noise, the offset between the views
///      marginalized (normal, `offset_search`). The costs of neighbors 1, 2 and 4 tiles away are added,
///      capped, so that a tile without texture takes its neighbors' and a depth edge stays where it is.
///   3. Gauss-Newton on the views interpolated by a windowed sinc, each pixel weighed by its noise, the offset
///      marginalized (`offset`). What noise alone adds to the curvature is known, and taken out of it. So is the part
///      of the difference that is due to the third moments of the kernels at this shift (`skew`), or fine texture
///      would be found up to a quarter farther from the focus than it is.
///   4. Beyond 1.4 px of shift, where blur is wider than a tile, the mean over the neighbors that agree.
///
/// sigma_dp_px is the predicted standard deviation of the error, at most range_px; root-sum-square of
///   - that of steps 3 and 4 (noise, offset), its square times 1 + 3 x the residual's excess over what noise explains
///     (mirrored kernels, depth edges; also the noise that taking out third moments adds, as a margin where the
///     kernels are not those that they are taken for);
///   - the spread of other shifts that step 2 cannot rule out (repetition, no texture);
///   - 0.02 d^2, at most 0.08 px: what matching mirrored half discs errs by from their centroids, whether third moments
///     are known or not. Right on the average of textures: beyond |b| = 4 px of blur a single one may err by more;
///   - 0.3 px times the root of the share of pixels that are left out, of the tile's inside the views: what is left may
///     be a highlight's rim;
///   - half the spread of disparity over 3 x 3 tiles beyond what their errors explain, where it clearly is: on a
///     slope, at an edge, in foliage a tile measures where its texture is;
///   - what a tile differs from its neighbors by, where fewer than 5 of 8 agree: highlights, structures narrower than
///     their blur, mistakes.
/// `shared` is the share of sigma^2 that neighbors have in common: 0.2 of all but the noise, and what step 4 pooled.
/// Confidence is 1 / (1 + (sigma / confident_sigma_dp_px)^2), and 0 where the least cost lies at an end of the range,
/// where step 3 left its shift by more than 1.5 px, or nothing was to be seen.
///
/// Pixels that are clipped or not finite are left out; empty views give an empty answer. The answer does not depend on
/// the number of threads. Throws InputError where the views' sizes differ, they have more than one channel, or an
/// option is out of range.
TileDisparity match_by_likelihood(const Image& left, const Image& right, const LikelihoodMatchOptions& options = {});

}  // namespace dualpixel::pipeline
