#include "capture/image/read_mask.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/error.h"
#include "capture/image/image_io.h"

namespace dualpixel {

Image read_mask(const std::string& path) {
  const Image picture = read_image(path);
  Image mask(picture.width, picture.height);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    mask.data[i] = picture.data[i * picture.channels];
    if (mask.data[i] >= 0 && mask.data[i] <= 1) continue;
    throw InputError(fmt::format("{}: pixel ({}, {}): {}: a mask's values must lie in [0, 1]", printable(path),
                                 i % mask.width, i / mask.width, mask.data[i]));
  }
  return mask;
}

void require_shape(const Image& mask, int picture_width, int picture_height, const std::string& name) {
  constexpr double kMostStretch = 0.02;
  const double width = picture_width, height = picture_height;
  const double excess = std::abs(mask.width * height - mask.height * width);
  if (excess <= std::max({kMostStretch * mask.width * height, width, height})) return;
  throw InputError(fmt::format("{}: {} x {} pixels; must have the shape of the picture, {} x {}", name, mask.width,
                               mask.height, picture_width, picture_height));
}

}  // namespace dualpixel
