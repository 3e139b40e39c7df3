#pragma once
#include <vector>

#include "capture/image/image.h"
#include "pipeline/option_field.h"
#include "pipeline/segmentation/faces.h"

/// From a picture to the mask of its people (Wadhwa et al. 2018, section 3.3): every face seeds one run of the network.
namespace dualpixel::pipeline {

class PersonNetwork;

struct SeedOptions {
  /// "at least one third the area of the largest face and larger than 1.3 % the area of the image" (section 3.3). The
  /// paper does not say how large its detector's boxes are. A known detector of frontal faces, dlib's, has boxes 1.18
  /// times as wide as those from brow to chin, and 0.013 / 1.18^2 of the picture takes the same people
  /// (docs/segmentation.md).
  double least_of_largest = 1.0 / 3;
  double least_of_picture = 0.0093;
};

OptionFields fields(SeedOptions& options);

/// Of the faces that a detector found in a picture of this size, those that are no bystanders', in their order.
std::vector<Face> seed_faces(const std::vector<Face>& faces, int width_px, int height_px,
                             const SeedOptions& options = {});

/// What the network sees: the picture (linear, white-balanced, one or three channels) in sRGB, its longer side 256 px,
/// centered on black, minus 0.5; and a Gaussian of sigma 21 px and peak 1 about the face's center.
Image network_input(const Image& linear_rgb, const Face& face);

/// The masks of all that `faces` seed, joined by maximum, 0..1: of the picture's shape, its longer side 256 px.
/// Pictures down to a pixel's width work. Faces' centers must lie in the picture.
Image person_mask(const Image& linear_rgb, const std::vector<Face>& faces, PersonNetwork& network);

struct FoundPeople {
  std::vector<Face> faces;     ///< that seeded the mask, largest first; none: there was no face to begin from
  Image mask;                  ///< person_mask's; empty without faces
  std::vector<Face> detected;  ///< those given, or all that find_faces found, bystanders' too; largest first
};

/// With the faces given, or else with those that find_faces and seed_faces leave.
FoundPeople find_people(const Image& linear_rgb, const std::vector<Face>& given, PersonNetwork& network,
                        const SeedOptions& options = {});

/// The people at the center of `tap`: those whose face, found by find_faces, or mask (above 1/2) covers it. The network
/// is not asked at the tap itself, for it finds a person wherever it is told that a face is.
FoundPeople find_people_at(const Image& linear_rgb, const Face& tap, PersonNetwork& network);

/// Whether any pixel of the mask exceeds 1/2: a face given where there is no person may leave a mask without one.
bool anybody_seen(const FoundPeople& found);

}  // namespace dualpixel::pipeline
