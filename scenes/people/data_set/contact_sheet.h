#pragma once
#include <vector>

#include "capture/image/image.h"
#include "scenes/people/sample.h"

namespace dualpixel::scenes {

/// The first samples, at most `most`, side by side: masks outlined, faces boxed, keypoints as dots (visible: full,
/// hidden: hollow). sRGB, 0..1.
Image contact_sheet(const std::vector<PeopleSample>& samples, int most, int columns);

}  // namespace dualpixel::scenes
