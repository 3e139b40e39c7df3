#include "pipeline/defocus/mask_blur.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "capture/error.h"
#include "capture/image/rows.h"
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/enlarge.h"
#include "pipeline/defocus/highlights.h"
#include "pipeline/defocus/scatter.h"

namespace dualpixel::pipeline {
namespace {

/// The picture with its highlights recovered where the background shows.
Image recovered(const Image& rgb, const Image& mask, float radius_px, const Bokeh& bokeh) {
  Image radii = mask;
  for (float& value : radii.data) value = radius_px * (1 - value);
  return recover_highlights(rgb, radii, bokeh.white, bokeh.highlights);
}

}  // namespace

OptionFields fields(MaskBlurOptions& options) {
  return {{"radius_px", &options.radius_px, 0, 1000, "px", "ours"},
          {"reference_width_px", &options.reference_width_px, 1, 1e6, "px", "ours"}};
}

MaskBlurOptions blur_for_face(double face_width_px, int image_width_px, MaskBlurOptions options) {
  constexpr double kPupilOverFace = 12.3e-3 / 0.15;
  if (!(face_width_px > 0)) return options;
  const double at_reference = face_width_px * options.reference_width_px / image_width_px;
  options.radius_px = std::min(kPupilOverFace / 2 * at_reference, 1.5 * options.radius_px);
  return options;
}

Defocused blur_background(const Image& rgb, const Image& mask, const MaskBlurOptions& options, const Bokeh& bokeh) {
  require_valid(bokeh.aperture);
  if (!mask.same_size(rgb)) {
    throw InputError(fmt::format("defocus: mask: {} x {}: must have the picture's size, {} x {}", mask.width,
                                 mask.height, rgb.width, rgb.height));
  }
  const int width = rgb.width, height = rgb.height;
  const int upright_width = bokeh.aperture.transposed ? height : width;
  const float radius = static_cast<float>(options.radius_px * upright_width / options.reference_width_px);
  const Layer background =
      cut_background(bokeh.recover_highlights ? recovered(rgb, mask, radius, bokeh) : rgb, mask, radius);
  const float brightest =
      bokeh.recover_highlights ? static_cast<float>(bokeh.white) : std::numeric_limits<float>::infinity();
  Image stack(background.rgba.width, background.rgba.height, 4);
  scatter_gradient(background, stack, bokeh.aperture);

  const RowEnlarger enlarged(stack, width);
  Defocused out{Image(width, height, 3), Image(width, height), Image(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> mixed, blurred;
    for (int y = rows.begin(); y < rows.end(); ++y) {
      enlarged(y, mixed, blurred);
      for (int x = 0; x < width; ++x) {
        const float down = bokeh.aperture.transposed ? (static_cast<float>(x) + 0.5f) / static_cast<float>(width)
                                                     : (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
        const float share = 1 - down;
        const float* disc = blurred.data() + 4 * static_cast<std::size_t>(x);
        const float weight = disc[3] > 1e-3f ? share * (1 - mask.row(y)[x]) : 0;
        for (int c = 0; c < 3; ++c) {
          const float own = rgb.row(y)[3 * x + c];
          out.rgb.row(y)[3 * x + c] = weight > 0 ? own + weight * (std::min(disc[c] / disc[3], brightest) - own) : own;
        }
        out.blurred.row(y)[x] = weight;
        out.radius_px.row(y)[x] = weight * radius;
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
