#include "pipeline/defocus/highlights.h"

#include <algorithm>
#include <cmath>
#include <vector>

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
          {"most", &options.most, 1, 1e6, "of white", "ours"},
          {"surroundings", &options.surroundings, 0, 1, "of the width", "ours"},
          {"lamp", &options.lamp, 0, 1, "of white", "ours"},
          {"surface", &options.surface, 0, 10, "of white", "ours"}};
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

Image lamp_shares(const Image& rgb, double white, const HighlightOptions& options) {
  const int width = rgb.width, height = rgb.height;
  constexpr int kSoftEdge_px = 4;  // of a lamp in focus: optics, and demosaicking
  const int reach = std::max(kSoftEdge_px, static_cast<int>(std::lround(options.surroundings * width)));
  const auto light = [&](int i) { return largest_channel(&rgb.data[3 * static_cast<std::size_t>(i)]) / white; };
  Image shares(width, height);
  std::vector<int> seen(shares.data.size(), -1);  // the patch that last came by
  std::vector<int> patch, rim, next;
  /// Unseen neighbors of `pixel`, clipped ones or the others, to `found`.
  const auto visit = [&](int pixel, bool clipped, int id, std::vector<int>& found) {
    const int x = pixel % width, y = pixel / width;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
      for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
        const int i = v * width + u;
        if (seen[i] == id || (light(i) >= options.clipped) != clipped) continue;
        seen[i] = id;
        found.push_back(i);
      }
    }
  };
  for (int i = 0; i < width * height; ++i) {
    if (light(i) < options.clipped || seen[i] >= 0) continue;
    seen[i] = i;
    patch = {i};
    for (std::size_t k = 0; k < patch.size(); ++k) visit(patch[k], true, i, patch);
    rim = patch;
    bool bounded = false;
    for (int step = 0; step < reach; ++step) {
      next.clear();
      for (const int pixel : rim) visit(pixel, false, i, next);
      if (next.empty()) break;
      rim.swap(next);
      bounded = true;
    }
    double sum = 0;
    for (const int pixel : rim) sum += light(pixel);
    const double around = bounded ? sum / static_cast<double>(rim.size()) : options.surface;
    const double share = (options.surface - around) / std::max(options.surface - options.lamp, 1e-6);
    for (const int pixel : patch) shares.data[pixel] = static_cast<float>(std::clamp(share, 0.0, 1.0));
  }
  return shares;
}

Image recover_highlights(Image rgb, const Image& radius_px, double white, const HighlightOptions& options) {
  const auto extra = static_cast<float>(highlight_gain(rgb, white, options) - 1);
  const auto clipped = static_cast<float>(options.clipped * white);
  const auto half_blur_px = static_cast<float>(options.full_blur_px / 2);
  const Image lamps = lamp_shares(rgb, white, options);
  for_rows(rgb.height, [&](int y) {
    float* pixel = rgb.row(y);
    for (int x = 0; x < rgb.width; ++x, pixel += 3) {
      if (largest_channel(pixel) < clipped) continue;
      const float share = lamps.row(y)[x] * std::clamp(radius_px.row(y)[x] / half_blur_px - 1, 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) pixel[c] *= 1 + share * extra;
    }
  });
  return rgb;
}

}  // namespace dualpixel::pipeline
