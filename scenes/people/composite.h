#pragma once
#include <vector>

#include "scenes/people/picture.h"

namespace dualpixel::scenes {

/// The people of a rendering in front of a random part of another background, linear.
Image composite_of(const Rendering& rendering, Image background, RandomStream rng);

/// Linear light processed to sRGB, exposed for the people of `coverage` (which may be empty) as much as for the
/// picture.
std::vector<std::uint8_t> photograph_of(Image light, const Image& coverage, RandomStream rng);

/// Processes linear light to sRGB, centers it in the square and appends a sample for each of `subjects`.
void add_samples(const PeoplePicture& picture, const std::vector<Subject>& subjects, Image light, RandomStream rng,
                 std::vector<PeopleSample>& out);

}  // namespace dualpixel::scenes
