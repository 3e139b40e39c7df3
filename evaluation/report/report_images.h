#pragma once
#include <string>

#include "capture/image/image.h"

/// Pictures for the report: reduced, colored, and packed into the page itself.
namespace dualpixel::evaluation {

/// `image` at width x height, each pixel the mean over the area that it covers. Values that are not finite are left
/// out; a pixel with nothing else is NaN.
Image resized(const Image& image, int width, int height);

/// Signed values as color, -limit ... 0 ... limit: blue, near white, orange, of equal lightness and chroma on both
/// sides (straight lines in Oklab; Ottosson 2020, "A perceptual color space for image processing"), so that neither
/// sign stands out. Beyond the limit the color stays; NaN is gray. Returns sRGB, 0..1.
Image diverging_colors(const Image& values, float limit);

/// 0 ... limit as black ... white, equal steps of the sRGB code; NaN is gray.
Image gray_levels(const Image& values, float limit);

/// The value below which `share` (0..1) of the finite values lie; 0 where there are none.
float percentile(const Image& image, double share);

/// jpeg() as "data:image/jpeg;base64,...".
std::string jpeg_data_uri(const Image& srgb, int quality = 85);

std::string base64(const std::string& bytes);

}  // namespace dualpixel::evaluation
