#include "capture/image/read_mask.h"

#include <fmt/format.h>

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

}  // namespace dualpixel
