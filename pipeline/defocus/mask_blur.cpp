#include "pipeline/defocus/mask_blur.h"

#include <fmt/format.h>

#include "capture/error.h"
#include "pipeline/defocus/enlarge.h"
#include "pipeline/defocus/scatter.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

float background_radius_px(int width, const MaskBlurOptions& options) {
  return static_cast<float>(options.radius_px * width / options.reference_width_px);
}

}  // namespace

Image background_radii(const Image& mask, const MaskBlurOptions& options) {
  const float radius = background_radius_px(mask.width, options);
  Image radii = mask;
  for (float& value : radii.data) value = radius * (1 - value);
  return radii;
}

MaskBlurred blur_background(const Image& rgb, const Image& mask, const MaskBlurOptions& options,
                            const Aperture& aperture) {
  require_valid(aperture);
  if (!mask.same_size(rgb)) {
    throw InputError(fmt::format("defocus: mask: {} x {}: must have the picture's size, {} x {}", mask.width,
                                 mask.height, rgb.width, rgb.height));
  }
  const int width = rgb.width, height = rgb.height;
  const float radius = background_radius_px(width, options);
  const Layer background = cut_background(rgb, mask, radius);
  Image stack(background.rgba.width, background.rgba.height, 4);
  scatter_gradient(background, stack, aperture);

  const RowEnlarger enlarged(stack, width, height);
  MaskBlurred out{{Image(width, height, 3), Image(width, height)}, Image(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> mixed, blurred;
    for (int y = rows.begin(); y < rows.end(); ++y) {
      enlarged(y, mixed, blurred);
      const float share = 1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
      for (int x = 0; x < width; ++x) {
        const float* disc = blurred.data() + 4 * static_cast<std::size_t>(x);
        const float weight = disc[3] > 1e-3f ? share * (1 - mask.row(y)[x]) : 0;
        for (int c = 0; c < 3; ++c) {
          const float own = rgb.row(y)[3 * x + c];
          out.picture.rgb.row(y)[3 * x + c] = weight > 0 ? own + weight * (disc[c] / disc[3] - own) : own;
        }
        out.picture.blurred.row(y)[x] = weight;
        out.radius_px.row(y)[x] = weight * radius;
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
