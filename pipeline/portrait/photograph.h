#pragma once
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/image/image.h"

/// Any photograph, for mode seg (Wadhwa et al. 2018, section 3: "selfies").
namespace dualpixel::pipeline {

struct Photograph {
  Capture capture;                   ///< one frame without mosaic, views or truth: the picture's size and its noise
  Image picture;                     ///< linear RGB, upright: PortraitOptions::picture
  std::vector<std::string> assumed;  ///< for people: what the file does not say
};

inline constexpr int kMostMegapixels = 128;

/// A JPEG, PNG or TIFF of 8 or 16 bits, gray or RGB, or a DNG (LibRaw develops it). Alpha is ignored. Values are taken
/// for sRGB unless the file declares linear light; ICC profiles are not applied. It is turned upright as its EXIF
/// orientation says. Noise is estimated from the green channel, as shot noise (noise_model.h); gray pictures are given
/// none. Throws InputError where the file cannot be used: another format, colors that are neither gray nor RGB, more
/// than kMostMegapixels, values that are not in [0, 1].
Photograph read_photograph(const std::string& path);

/// Noise of a finished picture, linear RGB, for what is blurred: estimated from its green, as shot noise, in numbers of
/// 0 to 65535. 0 where it is gray, as synthetic noise is colored.
NoiseProfile noise_of(const Image& rgb);

/// A picture as it was meant to be seen: `orientation` is TIFF's tag 274, 1 to 8.
Image turned_upright(const Image& stored, int orientation);

}  // namespace dualpixel::pipeline
