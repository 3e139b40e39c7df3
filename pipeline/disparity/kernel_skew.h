#pragma once
#include <array>
#include <vector>

/// How the views' kernels differ from shifts of one another. A kernel multiplies frequency f by
///     exp(-2 pi i f . mean - ... + (2 pi i)^3 / -6 sum of third central moments times f^3 ...),
/// so that the shift seen at frequency f is the disparity, of the kernels' centroids, plus a term in f^2 from their
/// third moments. Even along x, those of the two views are of opposite sign; what they have in common moves neither
/// view against the other.
namespace dualpixel::pipeline {

/// Half the difference right - left of the kernels' third central moments, the x-axis along the baseline.
struct KernelSkew {
  float xxx = 0;  ///< DP px^3
  float xyy = 0;  ///< DP px times the square of a DP pixel's height
};

/// Both at every disparity d: polynomials of d, whose coefficients begin with that of 1. Third moments stand for whole
/// kernels only as long as these are narrow: beyond `farthest_dp_px` they stay as they are there.
struct SkewCurve {
  using Coefficients = std::array<float, 6>;
  Coefficients xxx{}, xyy{};
  float farthest_dp_px = 0;

  KernelSkew at(float disparity_dp_px) const;
  KernelSkew slope_at(float disparity_dp_px) const;  ///< its derivative by the disparity
};

/// The same in pixels `side` times as wide and as high.
SkewCurve in_larger_pixels(const SkewCurve& curve, int side);

/// Of an ideal split of this alpha, see split/split_shape.h; `pixel_height` is a DP pixel's over its width. Third
/// moments are in d^3; a term in d^5 makes up for the fifth and higher ones, such that the shift is right at 0.15
/// cycles a pixel's width, along the baseline and across it. Ends at a blur of 6 DP px: farther, frequencies from 0.2
/// cycles a pixel on lie past the first zero of the blur.
SkewCurve skew_of_split(double alpha, double pixel_height);

/// Over the picture, from border to border: node (i, j) of row after row at (i / (columns - 1) * width, j / (rows - 1)
/// * height), linear in between. One node holds everywhere; none says that views are shifts of one another.
struct SkewField {
  int columns = 0, rows = 0;
  std::vector<SkewCurve> nodes;

  /// x and y are fractions of the picture.
  SkewCurve at(double x, double y) const;
};

/// a + share (b - a), of two fields of the same nodes.
SkewField mixed(const SkewField& a, const SkewField& b, float share);

/// Of a part of the picture: from (x, y), `width` wide and `height` high, fractions of it.
SkewField of_part(const SkewField& whole, double x, double y, double width, double height);

}  // namespace dualpixel::pipeline
