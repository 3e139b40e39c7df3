#pragma once
#include <vector>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// The aligned burst as one picture with less noise and no ghosts (Hasinoff et al. 2016, section 5).
namespace dualpixel::pipeline {

/// Signals normalized as (DN - black) / (white - black): 0 is black, 1 is clipped; noise may go below 0.
struct MergedBurst {
  Image mosaic;  ///< full sensor size; empty where the frames hold no mosaic
  Image left;    ///< DP size
  Image right;
  int base_frame = 0;  ///< whose scene and pose it shows
};

/// Variance that merging a static burst at the default strength leaves in a mosaic and in the views, over that of one
/// frame: 1/N of the mean, and what the shrinkage keeps of the base, which is 0.040 and 0.025 of (1 - 1/N) within 5 %
/// for N from 3 on (expectation of the formula below over Gaussian noise, by Monte Carlo).
inline double merged_mosaic_variance(int frames) { return 1.0 / frames + 0.040 * (1 - 1.0 / frames); }
inline double merged_view_variance(int frames) { return 1.0 / frames + 0.025 * (1 - 1.0 / frames); }

struct MergeOptions {
  /// c of the shrinkage: more merges more, and leaves more of what moved. 8 as in the paper's supplement; 75 is the
  /// setting of one public program.
  double strength = 8;
};

OptionFields fields(MergeOptions& options);

/// Merges all frames into frame `base`, tile by tile in the frequency domain. With T_0 the transform of a windowed tile
/// of the base, T_z that of frame z at the position that `motions` gives, and D_z = T_0 - T_z, the merged tile is
///     1/N sum over z of T_z + A_z D_z,   A_z = P / (P + c V),   P = |D_z|^2,   V = 2 W sigma^2:
/// V is what noise alone puts into P. sigma^2 = S * RMS + O from the noise profile, at the root mean square of the
/// base's tile above black, and W is the sum of the squared window. (The paper writes n^2/16 for W of n x n px; for
/// the window below W is n^2 * 9/64, and only with it has a static burst the noise of section 5: for N = 6, 9
/// frames sigma * 0.447, 0.382 at c = 8 and 0.409, 0.335 at c = 75, where a plain mean has 0.408, 0.333.)
///
/// Tiles are 16 x 16 px of each Bayer plane and of each DP view, overlapping by half, under the window
/// 1/2 - 1/2 cos(2 pi (x + 1/2) / 16) along each axis, whose copies sum to 1. A motion's whole pixels choose where a
/// tile is cut, the rest is a shift of its phases; its window is shifted the other way, so that it lies right after.
///
/// That alone leaves ghosts weaker than noise, which add up over the frames. So D_z is dropped as well (A_z = 1) where
/// its energy, summed over two planes and all frequencies, is more than 1.8 times what noise explains, and its share
/// falls to that from 1.4; here each pixel has its own variance, and a clipped one none. Ours: with it a moving object
/// has no more error than in the base, and clipped highlights don't ring. It asks for a profile that is right: where
/// noise is twice what the profile says, the base alone remains.
///
/// The DP views stay at their own resolution, where their noise is white (the paper enlarges them to the Bayer planes'
/// size): a tile of theirs takes the motion of the Bayer tile at its center, in its own pixels. Both views are shifted
/// by the same fraction of a pixel, and share one A_z, with P and V summed over both: every frequency of both views is
/// then merged with the same weights, so that the disparity of the merged views is that of the frames. Four real
/// numbers instead of two make A_z steadier: a noise of 0.432, 0.364 for 6, 9 frames at c = 8. The test of energies is
/// made apart for |ky| < 4 and above, from 1.9 to 2.3: the views' high vertical frequencies are aliased (their pixels
/// are twice as high as wide) and must not affect the rest, which disparity depends on.
///
/// Beyond its border a frame is mirrored: unlike what the base shows there, hence rejected. A variance below
/// 1/12 DN^2, that of rounding, is taken as 1/12: so a profile of zeros is allowed.
///
/// `motions` holds one field per frame, as align_burst() returns them. Throws as require_burst(), and
/// InputError where `base` is none of the frames, a field's size is wrong or a motion not finite, or the
/// strength is not 0.001 to 1e6.
MergedBurst merge_burst(const std::vector<Frame>& frames, int base, const std::vector<Image>& motions,
                        const Exposure& exposure, const MergeOptions& options = {});

/// sharpest_frame(), align_burst() and merge_burst().
MergedBurst align_and_merge(const std::vector<Frame>& frames, const Exposure& exposure,
                            const MergeOptions& options = {});

}  // namespace dualpixel::pipeline
