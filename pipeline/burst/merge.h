#pragma once
#include <vector>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// Merges the aligned frames of a burst into one picture with less noise and without ghosts of moving things (Hasinoff
/// et al. 2016, "Burst photography for high dynamic range and low-light imaging on mobile cameras", section 5).
namespace dualpixel::pipeline {

/// Signals are (DN - black) / (white - black): 0 is black, 1 is clipped; noise may go below 0.
struct MergedBurst {
  Image mosaic;  ///< full sensor size; empty where the frames hold no mosaic
  Image left;    ///< DP size; both views are empty where the frames hold none
  Image right;
  int base_frame = 0;  ///< the frame whose scene and camera pose the merged picture shows
};

/// Noise variance of a merged static burst over that of one frame, at the default strength, for the mosaic and for the
/// views. A plain mean would have 1/N. The merge keeps some of the base frame's noise as well: 0.040 (views: 0.025) of
/// (1 - 1/N), within 5 % for N >= 3 (the expectation of the formula below over Gaussian noise, by Monte Carlo).
inline double merged_mosaic_variance(int frames) { return 1.0 / frames + 0.040 * (1 - 1.0 / frames); }
inline double merged_view_variance(int frames) { return 1.0 / frames + 0.025 * (1 - 1.0 / frames); }

struct MergeOptions {
  /// c in the formula below. Larger values merge more: less noise, but more ghosts of moving things. 8 is the value of
  /// the paper's supplement; a public implementation uses 75.
  double strength = 8;
};

OptionFields fields(MergeOptions& options);

/// Merges all frames into frame `base`, tile by tile in the frequency domain (Hasinoff et al. 2016, section 5).
///
/// Tiles. 16 x 16 px of each Bayer plane and of each DP view, overlapping by half. Their window is
/// 1/2 - 1/2 cos(2 pi (x + 1/2) / 16) along each axis; its overlapping copies sum to 1. The whole pixels of a tile's
/// motion choose where it is cut from frame z. The fraction is a phase shift of its spectrum; the window is first
/// shifted the other way, so that the phase shift brings it back.
///
/// Shrinkage. T_0 is the spectrum of the base frame's windowed tile, T_z that of frame z along its motion, and
/// D_z = T_0 - T_z. The merged tile is
///     1/N sum over z of (T_z + A_z D_z),   A_z = P / (P + c V),   P = |D_z|^2,   V = 2 W sigma^2.
/// V is the P that noise alone gives, so A_z is near 0 (average the frames) where the frames agree up to noise, and
/// near 1 (keep the base) where they differ. sigma^2 = S * RMS + O is the noise profile's variance at the root mean
/// square of the base tile above black. W is the sum of the squared window. The paper writes n^2/16 for a tile of n x n
/// px; this window has W = n^2 * 9/64. With that, a static burst has the noise that section 5 states. Over the noise of
/// one frame, for N = 6 and 9: 0.447 and 0.382 at c = 8, 0.409 and 0.335 at c = 75, and 0.408 and 0.333 for a plain
/// mean.
///
/// Rejection (ours). Shrinkage alone leaves ghosts that are weaker than the noise of one frame, and they add up over
/// the frames. So a tile is also judged as a whole: the energy of D_z, summed over two planes and all frequencies but
/// the mean's, is compared with the energy that noise explains. Up to 1.4 times that, the tile is merged as above;
/// from 1.8 times on it is not merged (A_z = 1); in between the two are blended linearly. The tile's mean (|kx|, |ky|
/// <= 1) does not count: light that flickers changes it, and its own A_z keeps the base's, to a sixth of a pixel's
/// standard deviation for six frames at c = 8. It counts where a pixel of the base's tile clips, as a full well does
/// not flicker. For this test each pixel has its own variance, and a clipped pixel has none, or that of the read-out
/// where wells are full below the signal 1. With it a moving object has no more error than in the base frame, and
/// clipped highlights don't ring. It needs a noise profile that is right: where the noise is twice what the profile
/// says, nothing is merged and the base frame remains.
///
/// DP views. They are merged at their own resolution, where their noise is white; the paper enlarges them to the
/// size of the Bayer planes. A view's tile takes the motion of the Bayer tile at its center, in its own pixels. Both
/// views are shifted by the same fraction of a pixel and share one A_z, with P and V summed over both. So both views
/// are merged with the same weight at every frequency, and the merged views have the disparity of the frames. A_z from
/// four real numbers instead of two varies less: the noise is 0.432 and 0.364 for 6 and 9 frames at c = 8. The
/// rejection test is made separately for |ky| < 4 and above, with limits of 1.9 and 2.3: a view's pixel is twice as
/// high as wide, so high vertical frequencies are aliased, and they must not affect the others, on which disparity
/// depends.
///
/// Borders and rounding. Beyond its border a frame is mirrored; that does not match the base frame and is rejected.
/// The variance is at least 1/12 DN^2, that of rounding, so a noise profile of zeros is allowed.
///
/// `motions` holds one field per frame, as align_burst() returns them. Throws as require_burst(), and InputError where
/// `base` is none of the frames, a field's size is wrong, a motion is not finite, or the strength is not 0.001 to 1e6.
MergedBurst merge_burst(const std::vector<Frame>& frames, int base, const std::vector<Image>& motions,
                        const Exposure& exposure, const MergeOptions& options = {});

/// sharpest_frame(), align_burst() and merge_burst() in one call.
MergedBurst align_and_merge(const std::vector<Frame>& frames, const Exposure& exposure,
                            const MergeOptions& options = {});

}  // namespace dualpixel::pipeline
