#pragma once
#include <vector>

#include "capture/capture.h"
#include "capture/image/image.h"

/// Where each part of the base frame is found in the other frames of a hand-held burst (Hasinoff et al. 2016, "Burst
/// photography for high dynamic range and low-light imaging on mobile cameras", section 4 and supplement).
namespace dualpixel::pipeline {

/// The tiles that motion is measured and applied for, in Bayer px (photosites of one color; two photosites of the
/// sensor): squares of kMotionTile px, each overlapping the next by half. Tile (i, j) is centered on the corner of
/// pixels (kMotionStep i, kMotionStep j): at the border one half of it lies outside of the picture.
inline constexpr int kMotionTile = 16;
inline constexpr int kMotionStep = kMotionTile / 2;

/// Tiles along an axis of `plane_size` Bayer px.
inline int motion_tiles(int plane_size) { return (plane_size + kMotionStep - 1) / kMotionStep + 1; }

struct PlaneSize {
  int width, height;
};
/// Of a frame's Bayer planes. One without a mosaic is taken to have planes as wide as a view and twice as high, as
/// where a DP pixel is 2 x 4 photosites.
PlaneSize plane_size(const Frame& frame);

/// Two channels, x and y, in Bayer px; motion_tiles() of the planes' sides:
/// what the base shows at p, the frame shows at p + motion. It holds for all planes and both DP views alike.
using MotionField = Image;

/// Throws InputError, with one line that names frame and field, where there is no frame, mosaics or views are not of
/// one size (or only some frames have a mosaic, or views), a mosaic's sides are odd, a view is empty that another one
/// or the lack of a mosaic makes necessary, the white level is not above the black level, or a noise profile is
/// negative or not finite.
void require_burst(const std::vector<Frame>& frames, const Exposure& exposure);

/// The frame that the others are aligned to: the sharpest of the first three, near to the press of the shutter.
/// Sharpness is the sum of squared differences between neighbors of the plane of photosites (1, 0), which is green in
/// RGGB and BGGR, or between pixels of the left view where there is no mosaic. A later frame must be sharper by 1 %:
/// then noise alone, at a phone's size, does not prefer it, and a static burst keeps its first frame, which
/// docs/capture.md makes the reference. Throws as require_burst().
int sharpest_frame(const std::vector<Frame>& frames, const Exposure& exposure);

/// The motion of every frame against frame `base`, whose own field is 0.
///
/// The paper (Wadhwa et al. 2018, section 4.1) aligns all six channels of a frame, four of color and two views. The
/// views are green light of the same photosites at half the width and a quarter of the height: they add noise to what
/// the planes show already, and their difference is disparity, not motion.
///
/// Gray is the mean of the four Bayer planes (of a capture without mosaic: the sum of the views, enlarged to
/// plane_size()). Its pyramid shrinks by 2, 4, 4; from the coarsest level up, tiles of 8, 16, 16, 16 px, overlapping by
/// half and moved into the picture at its border, are searched over +-4, 4, 4, 1 px around the best of three coarser
/// motions by absolute differences: the nearest tile's and its next neighbors' in x and in y. The search is by squared
/// differences, at the finest level by absolute ones; each minimum is refined by a bivariate quadratic through the
/// squared differences around it. Parameters as in the public implementation at IPOL.
///
/// The search reaches 4 * 32 + 4 * 8 + 4 * 2 + 1 = 169 Bayer px along each axis, and a fraction of up to a pixel of
/// each level more: 212 at the most. What moved further, or out of the picture, is given some motion within that reach:
/// merge_burst() finds no likeness there and keeps the base. A tile without any texture keeps the coarser level's
/// motion.
/// Throws as require_burst(), and where `base` is none of the frames.
std::vector<MotionField> align_burst(const std::vector<Frame>& frames, int base, const Exposure& exposure);

}  // namespace dualpixel::pipeline
