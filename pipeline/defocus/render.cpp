#include "pipeline/defocus/render.h"

#include <algorithm>

#include "pipeline/defocus/scatter.h"
#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

/// Premultiplied "over" (Porter and Duff 1984), in place on what lies behind.
void lay_over(const Image& front, Image& behind) {
  for_rows(front.height, [&](int y) {
    const float* from = front.row(y);
    float* to = behind.row(y);
    for (int x = 0; x < front.width; ++x) {
      // Discs that pile up beyond alpha 1 keep their colour.
      const float scale = 1 / std::max(from[4 * x + 3], 1.0f);
      const float open = 1 - scale * from[4 * x + 3];
      for (int c = 0; c < 4; ++c) to[4 * x + c] = scale * from[4 * x + c] + open * to[4 * x + c];
    }
  });
}

/// One row of an image enlarged to `width` x `height`, as resize_bilinear would have it.
void enlarged_row(const Image& image, int width, int height, int y, const std::vector<LinearTap>& columns,
                  std::vector<float>& mixed, std::vector<float>& out) {
  const LinearTap line = linear_tap(y, height, image.height);
  const float* low = image.row(line.low);
  const float* high = image.row(line.high);
  for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] = low[i] + line.weight_of_high * (high[i] - low[i]);
  for (int x = 0; x < width; ++x) {
    const float* a = mixed.data() + 4 * columns[x].low;
    const float* b = mixed.data() + 4 * columns[x].high;
    for (int c = 0; c < 4; ++c) out[4 * x + c] = a[c] + columns[x].weight_of_high * (b[c] - a[c]);
  }
}

constexpr float kLeastAlpha = 1e-3f;  // below it colours drown in rounding

}  // namespace

Defocused render_defocus(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px,
                         const BlurMapping& mapping, const LayerOptions& options) {
  const auto [low, high] = std::minmax_element(disparity_dp_px.data.begin(), disparity_dp_px.data.end());

  // Half-resolution stacks: the in-focus band with all behind it, and all in front of it.
  Image below((rgb.width + 1) / 2, (rgb.height + 1) / 2, 4);
  Image above = below;
  bool in_front = false;
  for (const Band& band : make_bands(*low, *high, mapping, options)) {
    const Layer layer = make_layer(rgb, disparity_dp_px, radius_px, band);
    lay_over(band.in_focus ? scatter_direct(layer) : scatter_gradient(layer), in_front ? above : below);
    in_front = in_front || band.in_focus;
  }

  std::vector<LinearTap> columns(rgb.width);
  for (int x = 0; x < rgb.width; ++x) columns[x] = linear_tap(x, rgb.width, below.width);
  Defocused out{Image(rgb.width, rgb.height, 3), Image(rgb.width, rgb.height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, rgb.height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> mixed(4 * static_cast<std::size_t>(below.width));
    std::vector<float> behind(4 * static_cast<std::size_t>(rgb.width)), front(behind.size());
    for (int y = rows.begin(); y < rows.end(); ++y) {
      enlarged_row(below, rgb.width, rgb.height, y, columns, mixed, behind);
      enlarged_row(above, rgb.width, rgb.height, y, columns, mixed, front);
      const float* input = rgb.row(y);
      for (int x = 0; x < rgb.width; ++x) {
        const float sharp = std::clamp(1.5f - radius_px.row(y)[x], 0.0f, 1.0f);
        const float open = 1 - front[4 * x + 3];
        const float alpha = front[4 * x + 3] + open * (sharp + (1 - sharp) * behind[4 * x + 3]);
        const bool seen = alpha > kLeastAlpha;
        for (int c = 0; c < 3; ++c) {
          const float own = input[3 * x + c];
          const float base = sharp * own + (1 - sharp) * behind[4 * x + c];
          out.rgb.row(y)[3 * x + c] = seen ? (front[4 * x + c] + open * base) / alpha : own;
        }
        out.blurred.row(y)[x] = seen ? 1 - open * sharp / alpha : 0;
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
