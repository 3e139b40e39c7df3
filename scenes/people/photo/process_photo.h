#pragma once
#include <cstdint>
#include <vector>

#include "capture/image/image.h"
#include "scenes/procedural/random_stream.h"

/// From linear light to the picture that a phone saves.
namespace dualpixel::scenes {

/// Scales an image so that its mean luminance, weighted by `weight` where it is not empty, is `mean`.
void set_mean_luminance(Image& light, const Image& weight, float mean);

/// White balance errors, shot and read noise, vignetting, saturation, a tone curve, and sharpening or softness. Returns
/// 8-bit sRGB, three channels. `light`: linear, 1 is white.
std::vector<std::uint8_t> process_photo(Image light, RandomStream rng);

}  // namespace dualpixel::scenes
