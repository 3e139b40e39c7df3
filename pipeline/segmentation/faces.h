#pragma once
#include <vector>

#include "capture/image/image.h"

/// The faces that seed the segmentation (Wadhwa et al. 2018, section 3.3).
namespace dualpixel::pipeline {

/// A box from brow to chin, in pixels of the picture it was found in; it may reach over the border.
struct Face {
  double x = 0, y = 0, width = 0, height = 0;
  double area() const { return width * height; }
};

/// Whether this build has dlib; without it, find_faces throws InputError.
bool has_face_detector();

/// The frontal faces of a picture, linear RGB, largest first: dlib's detector (histograms of oriented gradients, King
/// 2015) on the picture scaled to 640 px on its longer side, where it finds faces of 80 px and more; where it finds
/// none, again on twice that size. Negative values and NaN count as black.
std::vector<Face> find_faces(const Image& linear_rgb);

}  // namespace dualpixel::pipeline
