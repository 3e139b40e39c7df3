#include "pipeline/defocus/layers.h"

#include <algorithm>
#include <cmath>

#include "capture/image/rows.h"
#include "pipeline/defocus/rgba.h"

namespace dualpixel::pipeline {
namespace {

Band make_band(double low, double high, bool in_focus, double overlap) {
  return {low, high, overlap * (high - low), in_focus};
}

float band_alpha(float disparity, float low, float high, float per_taper) {
  return std::clamp(1 + std::min(disparity - low, high - disparity) * per_taper, 0.0f, 1.0f);
}

/// set(x, alpha) for each pixel of a row of disparities.
template <typename Set>
void alphas_of_row(const Band& band, const float* disparity, int width, const Set& set) {
  const auto low = static_cast<float>(band.low_dp_px), high = static_cast<float>(band.high_dp_px);
  const auto per_taper = static_cast<float>(1 / band.taper_dp_px);
  for (int x = 0; x < width; ++x) set(x, band_alpha(disparity[x], low, high, per_taper));
}

/// alphas_of(y, row) gives a row's alphas, radius_of(x, y) a pixel's radius in full-resolution px.
template <typename Alphas, typename Radius>
void cut(const Image& rgb, Layer& layer, const Alphas& alphas_of, const Radius& radius_of) {
  const int width = (rgb.width + 1) / 2, height = (rgb.height + 1) / 2;
  if (layer.rgba.width != width || layer.rgba.height != height) layer = {Image(width, height, 4), Image(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
    // 0 beyond the picture's last column and row
    std::vector<float> alphas[2] = {std::vector<float>(2 * width), std::vector<float>(2 * width)};
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const int lines = std::min(2, rgb.height - 2 * y);
      if (lines == 1) std::fill(alphas[1].begin(), alphas[1].end(), 0.0f);
      for (int k = 0; k < lines; ++k) alphas_of(2 * y + k, alphas[k].data());
      float* out = layer.rgba.row(y);
      float* radius = layer.radius_px.row(y);
      std::fill_n(out, 4 * width, 0.0f);
      std::fill_n(radius, width, 0.0f);
      for (int x = 0; x < width; ++x) {
        const float* const alpha[2] = {&alphas[0][2 * x], &alphas[1][2 * x]};
        const float total = alpha[0][0] + alpha[0][1] + alpha[1][0] + alpha[1][1];
        if (total == 0) continue;
        Rgba sum{};
        float radii = 0;
        for (int k = 0; k < 4; ++k) {
          const float share = alpha[k / 2][k % 2];
          if (share == 0) continue;
          const int u = 2 * x + k % 2, v = 2 * y + k / 2;
          const float* color = rgb.row(v) + 3 * u;
          sum += share * Rgba{color[0], color[1], color[2], 1};
          radii += share * radius_of(u, v);
        }
        radius[x] = 0.5f * radii / total;  // half: full-resolution to working pixels
        store_rgba(sum / static_cast<float>(lines * std::min(2, rgb.width - 2 * x)), out + 4 * x);
      }
    }
  });
}

}  // namespace

OptionFields fields(LayerOptions& options) {
  return {{"bands", &options.bands, 3, 100, "", "5.2: 5"},
          {"overlap", &options.overlap, 0.01, 1, "of a band", "5.2: 0.25"},
          {"r_brute_px", &options.r_brute_px, 0.1, 1000, "px", "S: 5.5 (2.75 at half size)"}};
}

float Band::alpha(float disparity_dp_px) const {
  return band_alpha(disparity_dp_px, static_cast<float>(low_dp_px), static_cast<float>(high_dp_px),
                    static_cast<float>(1 / taper_dp_px));
}

float sharpness(float radius_px) { return std::clamp(1.5f - radius_px, 0.0f, 1.0f); }

std::vector<Band> make_bands(double low_dp_px, double high_dp_px, const BlurMapping& mapping,
                             const LayerOptions& options) {
  // What is in front may be blurred so little that the band has no end there: its taper counts ten times the back.
  constexpr double kMostFront = 10;
  const double focus_high = mapping.back_dp_px(options.r_brute_px);
  const double focus_low = std::max(mapping.front_dp_px(options.r_brute_px),
                                    mapping.focus_dp_px - kMostFront * (focus_high - mapping.focus_dp_px));
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

Image sums_of_tents(const Image& disparity_dp_px, const std::vector<Band>& bands) {
  Image sums(disparity_dp_px.width, disparity_dp_px.height);
  tbb::parallel_for(tbb::blocked_range<int>(0, sums.height, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      float* row = sums.row(y);
      for (const Band& band : bands) {
        alphas_of_row(band, disparity_dp_px.row(y), sums.width, [&](int x, float alpha) { row[x] += alpha; });
      }
    }
  });
  return sums;
}

void cut_band(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px, const Image& tent_sums,
              const Band& band, Layer& layer) {
  cut(
      rgb, layer,
      [&](int y, float* alphas) {
        const float* sums = tent_sums.row(y);
        alphas_of_row(band, disparity_dp_px.row(y), rgb.width,
                      [&](int x, float alpha) { alphas[x] = alpha > 0 ? alpha / sums[x] : 0; });
        if (!band.in_focus) return;
        for (int x = 0; x < rgb.width; ++x) alphas[x] *= 1 - sharpness(radius_px.row(y)[x]);
      },
      [&](int x, int y) { return radius_px.row(y)[x]; });
}

Layer cut_background(const Image& rgb, const Image& mask, float radius_px) {
  Layer layer;
  cut(
      rgb, layer,
      [&](int y, float* alphas) {
        for (int x = 0; x < rgb.width; ++x) alphas[x] = 1 - mask.row(y)[x];
      },
      [&](int, int) { return radius_px; });
  return layer;
}

}  // namespace dualpixel::pipeline
