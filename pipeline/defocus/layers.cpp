#include "pipeline/defocus/layers.h"

#include <algorithm>
#include <cmath>

#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

Band make_band(double low, double high, bool in_focus, double overlap) {
  return {low, high, overlap * (high - low), in_focus};
}

}  // namespace

float Band::alpha(float disparity_dp_px) const {
  const auto low = static_cast<float>(low_dp_px), high = static_cast<float>(high_dp_px);
  const float inside = std::min(disparity_dp_px - low, high - disparity_dp_px);
  return std::clamp(1 + inside / static_cast<float>(taper_dp_px), 0.0f, 1.0f);
}

std::vector<Band> make_bands(double low_dp_px, double high_dp_px, const BlurMapping& mapping,
                             const LayerOptions& options) {
  const double focus_low = mapping.front_dp_px(options.r_brute_px);
  const double focus_high = mapping.back_dp_px(options.r_brute_px);
  const double front = std::max(focus_low - low_dp_px, 0.0);
  const double back = std::max(high_dp_px - focus_high, 0.0);
  const int others = options.bands - 1;
  int front_bands = 0, back_bands = 0;
  if (front > 0 && back > 0) {
    front_bands = std::clamp(static_cast<int>(std::lround(others * front / (front + back))), 1, others - 1);
    back_bands = others - front_bands;
  } else if (front > 0) {
    front_bands = others;
  } else if (back > 0) {
    back_bands = others;
  }

  std::vector<Band> bands;
  for (int k = back_bands - 1; k >= 0; --k) {
    const double width = back / back_bands;
    bands.push_back(make_band(focus_high + k * width, focus_high + (k + 1) * width, false, options.overlap));
  }
  bands.push_back(make_band(focus_low, focus_high, true, options.overlap));
  for (int k = 0; k < front_bands; ++k) {
    const double width = front / front_bands;
    bands.push_back(make_band(focus_low - (k + 1) * width, focus_low - k * width, false, options.overlap));
  }
  return bands;
}

Layer make_layer(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px, const Band& band) {
  const int width = (rgb.width + 1) / 2, height = (rgb.height + 1) / 2;
  Layer layer{Image(width, height, 4), Image(width, height)};
  for_rows(height, [&](int y) {
    float* out = layer.rgba.row(y);
    for (int v = 2 * y; v < std::min(2 * y + 2, rgb.height); ++v) {
      const float* color = rgb.row(v);
      for (int u = 0; u < rgb.width; ++u) {
        const float alpha = band.alpha(disparity_dp_px.row(v)[u]);
        if (alpha == 0) continue;
        float* to = out + 4 * (u / 2);
        for (int c = 0; c < 3; ++c) to[c] += alpha * color[3 * u + c];
        to[3] += alpha;
        layer.radius_px.row(y)[u / 2] += alpha * radius_px.row(v)[u];
      }
    }
    const int lines = std::min(2, rgb.height - 2 * y);
    for (int x = 0; x < width; ++x) {
      const float alphas = out[4 * x + 3];
      if (alphas == 0) continue;
      layer.radius_px.row(y)[x] *= 0.5f / alphas;  // half: full-resolution to working pixels
      const float share = 1.0f / static_cast<float>(lines * std::min(2, rgb.width - 2 * x));
      for (int c = 0; c < 4; ++c) out[4 * x + c] *= share;
    }
  });
  return layer;
}

}  // namespace dualpixel::pipeline
