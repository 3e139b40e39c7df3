#pragma once
#include <vector>

#include "capture/image/image.h"

/// Which parts of a scene the renderings of several methods differ in most, for people who compare them (Wadhwa et al.
/// 2018, supplement, "User Study").
namespace dualpixel::evaluation {

struct Crop {
  int x = 0, y = 0, side = 0;  ///< upper left corner and side, in pixels
};

/// At most three squares of 128 pixels that do not overlap, or as large as fit: those with the largest variance between
/// the pictures, summed over their pixels and channels, the largest first. Where `mask` (of the pictures' size; empty:
/// none) has an outline, at .5, all hold a part of it. The pictures are of one size and at least two.
std::vector<Crop> crops_that_differ(const std::vector<Image>& pictures, const Image& mask);

/// The part of the picture.
Image cropped(const Image& picture, const Crop& crop);

}  // namespace dualpixel::evaluation
