#include "pipeline/edge_aware/joint_upsample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel::pipeline {
namespace {

/// exp(-t) within 0.02, as a polynomial that vectorizes: (1 - t/16)^16, 0 from 16 on.
inline float falloff(float t) {
  float base = std::max(1 - t * (1.0f / 16), 0.0f);
  base *= base;
  base *= base;
  base *= base;
  return base * base;
}

constexpr float kLeastSimilarity = 1e-6f;  // keeps the weights from vanishing where nothing resembles the pixel

/// One row of the small map and its guide, spread out to the large width: entry x is small pixel nearest(x) + offset.
struct SpreadRow {
  std::vector<float> value, red, green, blue;
  explicit SpreadRow(int width) : value(width), red(width), green(width), blue(width) {}
};

/// Adds one of the nine small pixels around each pixel of a row. Nothing overlaps: without saying so the loop would not
/// vectorize.
void add_tap(const SpreadRow& near, const float* __restrict weight_x, float weight_y, const SpreadRow& large,
             float range, float* __restrict sum, float* __restrict weights) {
  const float *__restrict value = near.value.data(), *__restrict red = near.red.data(),
              *__restrict green = near.green.data(), *__restrict blue = near.blue.data();
  const float *__restrict large_red = large.red.data(), *__restrict large_green = large.green.data(),
              *__restrict large_blue = large.blue.data();
  const int width = static_cast<int>(near.value.size());
  for (int x = 0; x < width; ++x) {
    const float dr = red[x] - large_red[x], dg = green[x] - large_green[x], db = blue[x] - large_blue[x];
    const float weight = weight_y * weight_x[x] * (falloff(range * (dr * dr + dg * dg + db * db)) + kLeastSimilarity);
    weights[x] += weight;
    sum[x] += weight * value[x];
  }
}

}  // namespace

OptionFields fields(JointUpsampleOptions& options) {
  return {{"sigma_px", &options.sigma_px, 0.1, 100, "px of the small map", "Kopf et al. 2007: 0.5"},
          {"sigma_range", &options.sigma_range, 0.1, 1e6, "levels of 255", "ours"}};
}

Image joint_upsample(const Image& small, const Image& small_guide, const Image& guide,
                     const JointUpsampleOptions& options) {
  const int width = guide.width, height = guide.height;
  const double scale_x = static_cast<double>(small.width) / width;
  const double scale_y = static_cast<double>(small.height) / height;
  const float spatial = 0.5f / (options.sigma_px * options.sigma_px);
  const float range = 0.5f / (options.sigma_range * options.sigma_range);

  std::vector<int> nearest(width);
  std::vector<float> weight_x[3];  // of the offsets -1, 0, 1
  for (std::vector<float>& weights : weight_x) weights.resize(width);
  for (int x = 0; x < width; ++x) {
    const double at = (x + 0.5) * scale_x;
    nearest[x] = std::min(static_cast<int>(at), small.width - 1);
    for (int k = -1; k <= 1; ++k) {
      const auto distance = static_cast<float>(nearest[x] + k + 0.5 - at);
      weight_x[k + 1][x] = std::exp(-spatial * distance * distance);
    }
  }

  Image out(width, height);
  // A block of output rows shares its small rows.
  tbb::parallel_for(tbb::blocked_range<int>(0, small.height), [&](const tbb::blocked_range<int>& lines) {
    std::vector<SpreadRow> spread(9, SpreadRow(width));
    SpreadRow large(width);
    std::vector<float> sum(width), weights(width);
    for (int line = lines.begin(); line < lines.end(); ++line) {
      for (int k = 0; k < 9; ++k) {
        const int v = std::clamp(line + k / 3 - 1, 0, small.height - 1);
        const float* values = small.row(v);
        const float* colors = small_guide.row(v);
        SpreadRow& row = spread[k];
        for (int x = 0; x < width; ++x) {
          const int u = std::clamp(nearest[x] + k % 3 - 1, 0, small.width - 1);
          row.value[x] = values[u];
          row.red[x] = colors[3 * u];
          row.green[x] = colors[3 * u + 1];
          row.blue[x] = colors[3 * u + 2];
        }
      }
      // The output rows whose nearest small row is this one.
      const auto first_row = [&](int index) { return static_cast<int>(std::ceil(index / scale_y - 0.5 - 1e-9)); };
      const int end = line + 1 == small.height ? height : std::min(first_row(line + 1), height);
      for (int y = std::max(first_row(line), 0); y < end; ++y) {
        const float* colors = guide.row(y);
        for (int x = 0; x < width; ++x) {
          large.red[x] = colors[3 * x];
          large.green[x] = colors[3 * x + 1];
          large.blue[x] = colors[3 * x + 2];
          sum[x] = weights[x] = 0;
        }
        for (int k = 0; k < 9; ++k) {
          const int at = line + k / 3;
          const auto distance = static_cast<float>(at - 0.5 - (y + 0.5) * scale_y);
          const float weight_y = std::exp(-spatial * distance * distance);
          add_tap(spread[k], weight_x[k % 3].data(), weight_y, large, range, sum.data(), weights.data());
        }
        float* to = out.row(y);
        for (int x = 0; x < width; ++x) to[x] = sum[x] / weights[x];
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
