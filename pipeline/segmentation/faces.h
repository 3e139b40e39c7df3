#pragma once
#include <vector>

#include "capture/image/image.h"
#include "pipeline/segmentation/face.h"

/// The faces that seed the segmentation (Wadhwa et al. 2018, section 3.3).
namespace dualpixel::pipeline {

/// The faces of a picture, linear RGB, largest first, turned up to 90 degrees from the camera: those of the network
/// (face_network.h) on the picture scaled to 320 px on its longer side, where it finds faces of 8 px and more. Negative
/// values and NaN count as black. Throws InputError in a build without oneDNN (has_person_network(), network.h).
std::vector<Face> find_faces(const Image& linear_rgb);

}  // namespace dualpixel::pipeline
