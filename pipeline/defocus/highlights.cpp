#include "pipeline/defocus/highlights.h"

#include <algorithm>
#include <cmath>

#include "capture/image/rows.h"

namespace dualpixel::pipeline {
namespace {

float largest_channel(const float* rgb) { return std::max({rgb[0], rgb[1], rgb[2]}); }

}  // namespace

OptionFields fields(HighlightOptions& options) {
  return {{"clipped", &options.clipped, 0.01, 1, "of white", "ours"},
          {"expected", &options.expected, 1.01, 100, "", "ours"},
          {"weight_px", &options.weight_px, 0, 1e9, "px", "ours"},
          {"full_blur_px", &options.full_blur_px, 0.01, 1000, "px", "ours"},
          {"most", &options.most, 1, 1e6, "of white", "ours"}};
}

double highlight_gain(const Image& rgb, double white, const HighlightOptions& options) {
  double seen = options.weight_px, logarithms = options.weight_px / options.expected;
  for (std::size_t i = 0; i < rgb.data.size(); i += 3) {
    const double v = largest_channel(&rgb.data[i]) / white;
    if (!(v > 0.5)) continue;
    const bool clipped = v >= options.clipped;
    seen += clipped ? 0 : 1;
    logarithms += std::log(2 * (clipped ? options.clipped : v));
  }
  const double steepness = seen / logarithms - 1;  // a - 1
  const double octaves = std::log(options.most);
  return 1 + (std::abs(steepness) < 1e-6 ? octaves : -std::expm1(-steepness * octaves) / steepness);
}

Image recover_highlights(Image rgb, const Image& radius_px, double white, const HighlightOptions& options) {
  const auto extra = static_cast<float>(highlight_gain(rgb, white, options) - 1);
  const auto clipped = static_cast<float>(options.clipped * white);
  const auto half_blur_px = static_cast<float>(options.full_blur_px / 2);
  for_rows(rgb.height, [&](int y) {
    float* pixel = rgb.row(y);
    for (int x = 0; x < rgb.width; ++x, pixel += 3) {
      if (largest_channel(pixel) < clipped) continue;
      const float share = std::clamp(radius_px.row(y)[x] / half_blur_px - 1, 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) pixel[c] *= 1 + share * extra;
    }
  });
  return rgb;
}

}  // namespace dualpixel::pipeline
