#pragma once
#include <array>

#include "capture/image/image.h"

/// Maps over the field as coarse grids, bicubic in between: what lenses do changes slowly over the picture.
namespace dualpixel::pipeline {

/// Node (i, j) lies at (i / (columns - 1) * width, j / (rows - 1) * height) of the picture: the outermost are on its
/// border. A focus distance's lines then take 7 kB in a file.
inline constexpr int kCalibrationColumns = 21;
inline constexpr int kCalibrationRows = 15;

Image node_image(float fill = 0);

/// The interval of `count` nodes that a fraction of the picture lies in, and how far along, 0..1.
struct NodeInterval {
  int first = 0;
  float t = 0;
};
NodeInterval node_interval(double fraction, int count);

/// Coefficients of 1, t, t^2, t^3 of the Catmull-Rom spline over interval `first` of `count` nodes that lie `stride`
/// floats apart. Beyond the border the nodes are extrapolated by a parabola.
std::array<float, 4> cubic_over(const float* nodes, int stride, int count, int first);

inline float evaluate(const std::array<float, 4>& cubic, float t) {
  return ((cubic[3] * t + cubic[2]) * t + cubic[1]) * t + cubic[0];
}

/// The row of `nodes` at a height given as an interval of rows: kCalibrationColumns values.
std::array<float, kCalibrationColumns> node_row(const Image& nodes, const NodeInterval& height);

/// `x` and `y` are fractions of the picture, clamped to it.
double bicubic(const Image& nodes, double x, double y);

/// Gives nodes where `known` is 0 the mean of their known neighbors, from the edge of each hole inwards. Nothing
/// changes where no node is known.
void fill_holes(const Image& known, Image& nodes);

}  // namespace dualpixel::pipeline
