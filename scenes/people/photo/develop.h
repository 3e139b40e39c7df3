#pragma once
#include <cstdint>
#include <vector>

#include "capture/image/image.h"
#include "scenes/people/dice.h"

/// From linear light to what a phone would have saved: wrong exposure and white balance at times, the sensor's shot and
/// read noise, a color matrix, a tone curve, sharpening or softness.
namespace dualpixel::scenes {

/// Multiplies an image so that the mean of its luminance, weighed by `weight` where it is not empty, is `mean`.
void set_mean_luminance(Image& light, const Image& weight, float mean);

/// sRGB, 8 bits, three channels. `light`: 1 is white.
std::vector<std::uint8_t> process_photo(Image light, RandomStream rng);

}  // namespace dualpixel::scenes
