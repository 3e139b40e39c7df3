#pragma once
#include <array>

#include "capture/image/image.h"
#include "pipeline/disparity/noise_model.h"

/// What the likelihood matcher's steps work on: both views padded, shaded alike, and the variance of every pixel; and
/// the small sums over tiles' columns that they share.
namespace dualpixel::pipeline::likelihood {

inline constexpr int kTile = 8;                   ///< side of a tile, DP px
inline constexpr float kInvalidVariance = 1e12f;  ///< variance of an invalid pixel
inline constexpr int kInvalidMargin =
    2;  ///< pixels beside an invalid one, or a border, that interpolation would mix it into

using Columns = std::array<float, kTile>;  ///< one entry for each column of a tile: what the compiler makes vectors of

inline float square(float value) { return value * value; }

inline float sum(const Columns& lanes) {
  std::array<float, kTile / 2> half;
  for (int i = 0; i < kTile / 2; ++i) half[i] = lanes[i] + lanes[i + kTile / 2];
  return (half[0] + half[2]) + (half[1] + half[3]);
}

/// Of the difference of two pixels of these variances; 0 where either is invalid.
inline float weight(float left_variance, float right_variance) {
  const float variance = left_variance + right_variance;
  return variance < kInvalidVariance ? 1 / variance : 0.0f;
}

/// One view, with `margin` pixels on both sides of each row, and rows up to whole tiles: no shift leaves it.
struct PreparedView {
  int margin = 0;
  Image signal;    ///< gain taken out; what is not finite is replaced by its left neighbor
  Image smooth;    ///< signal under 1/4 1/2 1/4 along x and y
  Image variance;  ///< of signal's noise; kInvalidVariance in the margin and where the pixel cannot be used
};

struct PreparedViews {
  PreparedView left, right;
  int columns = 0, rows = 0;  ///< tiles
  int width = 0, height = 0;  ///< of the views, without padding
};

/// Both views multiplied and divided by the root of their local ratio, so that they are shaded alike. Pixels that are
/// not finite, or `clipped` and above, are invalid.
PreparedViews prepare_views(const Image& left, const Image& right, int margin, const ViewNoise& noise, float clipped);

/// Mean over the (2 reach + 1)^2 pixels around each, as many as there are.
Image box_mean(const Image& image, int reach);

}  // namespace dualpixel::pipeline::likelihood
