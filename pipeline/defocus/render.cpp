#include "pipeline/defocus/render.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/error.h"
#include "capture/image/rows.h"
#include "pipeline/defocus/enlarge.h"
#include "pipeline/defocus/highlights.h"
#include "pipeline/defocus/rgba.h"
#include "pipeline/defocus/scatter.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kLeastAlpha = 1e-3f;  // below it colors drown in rounding

/// Half-resolution stacks of blurred layers.
struct Stacks {
  Image below;  ///< the in-focus band with all behind it
  Image above;  ///< all in front of it; empty where there is nothing
};

Stacks blur_bands(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px,
                  const std::vector<Band>& bands, const Aperture& aperture) {
  Stacks stacks;
  stacks.below = Image((rgb.width + 1) / 2, (rgb.height + 1) / 2, 4);
  if (!bands.back().in_focus) stacks.above = stacks.below;
  const Image tent_sums = sums_of_tents(disparity_dp_px, bands);
  Layer layer;
  bool in_front = true;
  for (auto band = bands.rbegin(); band != bands.rend(); ++band) {  // from the nearest
    in_front &= !band->in_focus;
    cut_band(rgb, disparity_dp_px, radius_px, tent_sums, *band, layer);
    layer.in_front_of_focus = in_front;
    const auto scatter = band->in_focus ? scatter_direct : scatter_gradient;
    scatter(layer, in_front ? stacks.above : stacks.below, aperture);
  }
  return stacks;
}

void require_size(const Image& map, const Image& rgb, const char* name) {
  if (map.same_size(rgb)) return;
  throw InputError(fmt::format("defocus: {}: {} x {}: must have the picture's size, {} x {}", name, map.width,
                               map.height, rgb.width, rgb.height));
}

/// What the maps hold.
struct Extent {
  float low_dp_px = std::numeric_limits<float>::infinity();
  float high_dp_px = -std::numeric_limits<float>::infinity();
  float largest_px = 0;
  bool valid = true;  ///< disparities are finite, radii lie in [0, r_max]
};

Extent extent_of(const Image& disparity_dp_px, const Image& radius_px, float r_max_px) {
  return tbb::parallel_reduce(
      tbb::blocked_range<int>(0, radius_px.height, 64), Extent(),
      [&](const tbb::blocked_range<int>& rows, Extent extent) {
        const float* disparity = disparity_dp_px.row(rows.begin());
        const float* radius = radius_px.row(rows.begin());
        const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(rows.size()) * radius_px.width;
        for (std::ptrdiff_t i = 0; i < count; ++i) {
          extent.low_dp_px = std::min(extent.low_dp_px, disparity[i]);
          extent.high_dp_px = std::max(extent.high_dp_px, disparity[i]);
          extent.largest_px = std::max(extent.largest_px, radius[i]);
          extent.valid &= std::isfinite(disparity[i]) && radius[i] >= 0 && radius[i] <= r_max_px;
        }
        return extent;
      },
      [](const Extent& a, const Extent& b) {
        return Extent{std::min(a.low_dp_px, b.low_dp_px), std::max(a.high_dp_px, b.high_dp_px),
                      std::max(a.largest_px, b.largest_px), a.valid && b.valid};
      });
}

/// The same maps with what is not valid mended.
Defocused render_mended(const Image& rgb, Image disparity_dp_px, Image radius_px, const BlurMapping& mapping,
                        const LayerOptions& options, const Bokeh& bokeh) {
  const auto most = static_cast<float>(mapping.r_max_px);
  for (std::size_t i = 0; i < radius_px.data.size(); ++i) {
    float& disparity = disparity_dp_px.data[i];
    float& radius = radius_px.data[i];
    if (!std::isfinite(disparity)) {
      disparity = static_cast<float>(mapping.focus_dp_px);
      radius = 0;
    }
    radius = radius > 0 ? std::min(radius, most) : 0;
  }
  return render_defocus(rgb, disparity_dp_px, radius_px, mapping, options, bokeh);
}

}  // namespace

Defocused render_defocus(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px,
                         const BlurMapping& mapping, const LayerOptions& options, const Bokeh& bokeh) {
  require_valid(bokeh.aperture);
  require_size(disparity_dp_px, rgb, "disparity");
  require_size(radius_px, rgb, "radius");
  const int width = rgb.width, height = rgb.height;
  const Extent extent = extent_of(disparity_dp_px, radius_px, static_cast<float>(mapping.r_max_px));
  if (!extent.valid) return render_mended(rgb, disparity_dp_px, radius_px, mapping, options, bokeh);
  if (extent.largest_px == 0) return {rgb, Image(width, height), {}};
  const std::vector<Band> bands = make_bands(extent.low_dp_px, extent.high_dp_px, mapping, options);
  const Stacks stacks = bokeh.recover_highlights
                            ? blur_bands(recover_highlights(rgb, radius_px, bokeh.white, bokeh.highlights),
                                         disparity_dp_px, radius_px, bands, bokeh.aperture)
                            : blur_bands(rgb, disparity_dp_px, radius_px, bands, bokeh.aperture);
  const float brightest =
      bokeh.recover_highlights ? static_cast<float>(bokeh.white) : std::numeric_limits<float>::infinity();

  const RowEnlarger below(stacks.below, width);
  const RowEnlarger above(stacks.above.empty() ? stacks.below : stacks.above, width);
  Defocused out{Image(width, height, 3), Image(width, height), {}};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> mixed, behind, front(4 * static_cast<std::size_t>(width));
    for (int y = rows.begin(); y < rows.end(); ++y) {
      below(y, mixed, behind);
      if (!stacks.above.empty()) above(y, mixed, front);
      const float* radius = radius_px.row(y);
      const float* input = rgb.row(y);
      float* result = out.rgb.row(y);
      for (int x = 0; x < width; ++x) {
        const float sharp = sharpness(radius[x]);
        const Rgba own = {input[3 * x], input[3 * x + 1], input[3 * x + 2], 1};
        const Rgba nearer = load_rgba(front.data() + 4 * x);
        const Rgba beneath = lay_over(sharp * own, load_rgba(behind.data() + 4 * x));
        const Rgba laid = lay_over(nearer, beneath);
        const bool seen = laid[3] > kLeastAlpha;
        const Rgba color = seen ? laid / laid[3] : own;
        const float kept = beneath[3] > 0 ? sharp * (laid[3] - nearer[3]) / beneath[3] : 0;
        const float blurred = seen ? 1 - kept / laid[3] : 0;
        const float limit = blurred > 0 ? brightest : std::numeric_limits<float>::infinity();
        for (int c = 0; c < 3; ++c) result[3 * x + c] = std::min(color[c], limit);
        out.blurred.row(y)[x] = blurred;
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
