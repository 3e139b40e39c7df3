#include "pipeline/defocus/mask_blur.h"

#include <algorithm>

#include "pipeline/defocus/scatter.h"
#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {

MaskBlurred blur_background(const Image& rgb, const Image& mask, const MaskBlurOptions& options) {
  const int width = rgb.width, height = rgb.height;
  const auto radius = static_cast<float>(options.radius_px * width / options.reference_width_px);

  Image background(width, height, 4);
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const float alpha = 1 - mask.row(y)[x];
      for (int c = 0; c < 3; ++c) background.row(y)[4 * x + c] = alpha * rgb.row(y)[3 * x + c];
      background.row(y)[4 * x + 3] = alpha;
    }
  });
  Layer layer;
  layer.rgba = resize_area(background, (width + 1) / 2, (height + 1) / 2);
  layer.radius_px = Image(layer.rgba.width, layer.rgba.height, 1, radius / 2);
  const Image blurred = resize_bilinear(scatter_gradient(layer), width, height);

  MaskBlurred out{{Image(width, height, 3), Image(width, height)}, Image(width, height)};
  for_rows(height, [&](int y) {
    const float share = 1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    for (int x = 0; x < width; ++x) {
      const float* disc = blurred.row(y) + 4 * x;
      const float weight = disc[3] > 1e-3f ? share * (1 - mask.row(y)[x]) : 0;
      for (int c = 0; c < 3; ++c) {
        const float own = rgb.row(y)[3 * x + c];
        out.picture.rgb.row(y)[3 * x + c] = weight > 0 ? own + weight * (disc[c] / disc[3] - own) : own;
      }
      out.picture.blurred.row(y)[x] = weight;
      out.radius_px.row(y)[x] = weight * radius;
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
