#include "capture/shading.h"

#include <algorithm>

#include "capture/image/bilinear.h"
#include "capture/image/rows.h"

namespace dualpixel {

Image shading_gain(const Camera& camera) {
  const Image& light = camera.relative_light;
  if (light.empty()) return {};
  Image gain(camera.width_px, camera.height_px);
  const double columns_per_px = (light.width - 1.0) / (camera.width_px - 1);
  const double rows_per_px = (light.height - 1.0) / (camera.height_px - 1);
  for_rows(gain.height, [&](int y) {
    const BilinearTap down = bilinear_tap(y * rows_per_px, light.height);
    for (int x = 0; x < gain.width; ++x) {
      const BilinearTap across = bilinear_tap(x * columns_per_px, light.width);
      const double share = bilinear(across, down, [&](int column, int row) { return light.at(column, row); });
      gain.at(x, y) = static_cast<float>(1 / std::max(share, 1.0 / kMostShadingGain));
    }
  });
  return gain;
}

void correct_shading(Image& picture, const Image& gain, float white) {
  if (gain.empty()) return;
  for_rows(picture.height, [&](int y) {
    float* value = picture.row(y);
    for (int x = 0; x < picture.width; ++x) {
      for (int c = 0; c < picture.channels; ++c, ++value) {
        *value = std::min(*value * gain.at(x, y), std::max(*value, white));
      }
    }
  });
}

}  // namespace dualpixel
