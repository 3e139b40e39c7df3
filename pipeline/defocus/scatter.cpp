#include "pipeline/defocus/scatter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kDirectSteps = 16;  // a pixel
constexpr float kGradientSteps = 8;
constexpr int kStripRows = 64;

int step_of(float radius_px, float steps) { return static_cast<int>(std::lround(radius_px * steps)); }

/// Runs strip(y0, y1) over strips of output rows. Each strip takes from all source rows in order and adds to its own
/// rows only, so every sum has the same order however the picture is cut.
template <typename Strip>
void for_strips(int height, const Strip& strip) {
  tbb::parallel_for(0, (height + kStripRows - 1) / kStripRows,
                    [&](int s) { strip(s * kStripRows, std::min((s + 1) * kStripRows, height)); });
}

float largest(const Image& image) {
  return image.data.empty() ? 0 : *std::max_element(image.data.begin(), image.data.end());
}

inline void add(float* to, const float* color, float weight) {
  for (int c = 0; c < 4; ++c) to[c] += weight * color[c];
}

/// Rounding may leave traces of light where no disc reaches.
void clear_traces(float* rgba, int width) {
  for (int x = 0; x < width; ++x) {
    if (rgba[4 * x + 3] < 1e-5f) std::fill_n(rgba + 4 * x, 4, 0.0f);
  }
}

struct Kernel {
  int reach = 0;
  std::vector<float> weights;  ///< (2 reach + 1)^2, sum 1
};

Kernel antialiased_disc(float radius) {
  Kernel kernel;
  kernel.reach = static_cast<int>(std::ceil(radius + 0.5f)) - 1;
  double total = 0;
  for (int dy = -kernel.reach; dy <= kernel.reach; ++dy) {
    for (int dx = -kernel.reach; dx <= kernel.reach; ++dx) {
      const float distance = std::sqrt(static_cast<float>(dx * dx + dy * dy));
      kernel.weights.push_back(std::clamp(radius + 0.5f - distance, 0.0f, 1.0f));
      total += kernel.weights.back();
    }
  }
  for (float& weight : kernel.weights) weight = static_cast<float>(weight / total);
  return kernel;
}

/// Rows -reach..reach of a rasterised disc reach from -half_width to half_width.
struct Disc {
  int reach = 0;
  std::vector<int> half_widths;
  float weight = 1;  ///< 1 / pixels
};

Disc rasterised_disc(float radius) {
  Disc disc;
  disc.reach = static_cast<int>(radius);
  int pixels = 0;
  for (int dy = -disc.reach; dy <= disc.reach; ++dy) {
    const float chord = std::sqrt(std::max(radius * radius - static_cast<float>(dy * dy), 0.0f));
    disc.half_widths.push_back(static_cast<int>(chord));
    pixels += 2 * disc.half_widths.back() + 1;
  }
  disc.weight = 1.0f / static_cast<float>(pixels);
  return disc;
}

}  // namespace

Image scatter_direct(const Layer& layer) {
  const int width = layer.rgba.width, height = layer.rgba.height;
  std::vector<Kernel> kernels;
  for (int step = 0; step <= step_of(largest(layer.radius_px), kDirectSteps); ++step) {
    kernels.push_back(antialiased_disc(static_cast<float>(step) / kDirectSteps));
  }
  const int reach = kernels.back().reach;
  Image out(width, height, 4);
  for_strips(height, [&](int y0, int y1) {
    for (int y = std::max(y0 - reach, 0); y < std::min(y1 + reach, height); ++y) {
      for (int x = 0; x < width; ++x) {
        const float* color = layer.rgba.row(y) + 4 * x;
        if (color[3] == 0) continue;
        const Kernel& kernel = kernels[step_of(layer.radius_px.row(y)[x], kDirectSteps)];
        const int side = 2 * kernel.reach + 1;
        const int first = std::max(x - kernel.reach, 0), last = std::min(x + kernel.reach, width - 1);
        for (int v = std::max(y - kernel.reach, y0); v <= std::min(y + kernel.reach, y1 - 1); ++v) {
          const float* weights = kernel.weights.data() + (v - y + kernel.reach) * side + kernel.reach - x;
          float* row = out.row(v);
          for (int u = first; u <= last; ++u) add(row + 4 * u, color, weights[u]);
        }
      }
    }
    for (int y = y0; y < y1; ++y) clear_traces(out.row(y), width);
  });
  return out;
}

Image scatter_gradient(const Layer& layer) {
  const int width = layer.rgba.width, height = layer.rgba.height;
  std::vector<Disc> discs;
  for (int step = 0; step <= step_of(largest(layer.radius_px), kGradientSteps); ++step) {
    discs.push_back(rasterised_disc(static_cast<float>(step) / kGradientSteps));
  }
  const int reach = discs.back().reach;
  Image out(width, height, 4);
  for_strips(height, [&](int y0, int y1) {
    for (int y = std::max(y0 - reach, 0); y < std::min(y1 + reach, height); ++y) {
      for (int x = 0; x < width; ++x) {
        const float* color = layer.rgba.row(y) + 4 * x;
        if (color[3] == 0) continue;
        const Disc& disc = discs[step_of(layer.radius_px.row(y)[x], kGradientSteps)];
        for (int v = std::max(y - disc.reach, y0); v <= std::min(y + disc.reach, y1 - 1); ++v) {
          const int half = disc.half_widths[v - y + disc.reach];
          float* row = out.row(v);
          add(row + 4 * std::max(x - half, 0), color, disc.weight);
          if (x + half + 1 < width) add(row + 4 * (x + half + 1), color, -disc.weight);
        }
      }
    }
    for (int y = y0; y < y1; ++y) {
      float* row = out.row(y);
      double sum[4] = {};  // single precision would drift over a row
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 4; ++c) {
          sum[c] += row[4 * x + c];
          row[4 * x + c] = static_cast<float>(sum[c]);
        }
      }
      clear_traces(row, width);
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
