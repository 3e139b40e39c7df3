#pragma once
#include "capture/image/image.h"
#include "pipeline/disparity/noise_model.h"
#include "pipeline/disparity/split/options.h"

/// What the matcher compares at a quarter of the views' size.
namespace dualpixel::pipeline::split {

inline constexpr int kSamplePx = 4;     ///< DP pixels from sample to sample, along x and y
inline constexpr int kTileSamples = 2;  ///< samples along a tile's side
inline constexpr int kTilePx = kSamplePx * kTileSamples;

/// Sum and difference left - right of both views' band, over the local contrast: local means and the ratio of both
/// views' taken out. Mirrored at the border by `margin` samples on each side, and where tiles reach over it, the
/// difference with its sign changed on the left and right.
struct CoarseViews {
  int margin = 0;
  int columns = 0, rows = 0;  ///< tiles; the last may reach over the border
  Image sum, difference;
  Image usable;  ///< one pixel a tile: share of its pixels that are finite and not clipped in both views
  Image weight;  ///< one pixel a tile: 0 to 1, of its residuals; less where it has more contrast than its surroundings
};

CoarseViews make_coarse_views(const Image& left, const Image& right, const SplitMatchOptions& options, int margin);

/// How an image goes on beyond its left and right border. Mirrored there, a scene at disparity d would be at -d; it
/// keeps d where the views change places as well: their sum is even then, and their difference odd.
enum class Mirror { even, odd };

/// Gaussian of standard deviation `sigma` samples along x and y, mirrored at the border; above and below always even.
Image gaussian(const Image& image, double sigma, Mirror sides);

/// The Gaussian that the filters of split_filters.h bring along, samples; the views have the rest of low_pass_px.
inline constexpr double kFilterSmoothing = 0.8;

}  // namespace dualpixel::pipeline::split
