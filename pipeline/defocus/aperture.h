#pragma once
#include <array>
#include <vector>

#include "pipeline/defocus/options.h"

/// The shape that a point out of focus is blurred to.
namespace dualpixel::pipeline {

/// Throws InputError where a value is out of range.
void require_valid(const Aperture& aperture);

/// The convex shape of one point's blur of radius 1, x right, y down.
///
/// A polygon has the disc's area, so that a radius means the same for every shape. One corner points up behind the
/// focus and, as the two sides of the focus are each other's mirror images, down in front of it. A cat's eye has less
/// area, as the lens has there, and looks alike on both sides.
struct BlurShape {
  std::vector<std::array<double, 2>> normals;  ///< of a polygon's sides, unit length; empty when round
  double side_distance = 0;                    ///< of the sides from the middle
  double extent = 1;                           ///< of the farthest corner from the middle
  std::array<double, 2> cut = {0, 0};          ///< discs of radius `extent` around +cut and -cut bound a cat's eye
};

/// In the middle of the picture.
BlurShape blur_shape(const Aperture& aperture, bool in_front_of_focus);

/// Cuts `shape`, of this aperture, to the cat's eye at a field point: from the picture's middle, length 1 in the
/// corners.
void cut_to_cats_eye(BlurShape& shape, const Aperture& aperture, double field_x, double field_y);

/// What a line at height y has in common with the shape of radius r; none where end <= begin.
struct Chord {
  double begin = 0;
  double end = 0;
};
Chord chord(const BlurShape& shape, double radius, double y);

/// Distance of a point in the shape of radius r from its rim (to be exact, from the nearest line or circle that bounds
/// it); negative outside.
double depth_inside(const BlurShape& shape, double radius, double x, double y);

}  // namespace dualpixel::pipeline
