#include "capture/image/resample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel {
namespace {

/// Input samples [first, first + weights.size()) that one output sample averages; weights sum to 1.
struct AreaTap {
  int first = 0;
  std::vector<float> weights;
};

std::vector<AreaTap> area_taps(int out_size, int in_size) {
  std::vector<AreaTap> taps(out_size);
  const double scale = static_cast<double>(in_size) / out_size;
  for (int i = 0; i < out_size; ++i) {
    const double begin = i * scale;
    const double end = std::min<double>((i + 1) * scale, in_size);
    taps[i].first = static_cast<int>(begin);
    for (int k = taps[i].first; k < end; ++k) {
      const double covered = std::min<double>(k + 1, end) - std::max<double>(k, begin);
      taps[i].weights.push_back(static_cast<float>(covered / (end - begin)));
    }
  }
  return taps;
}

}  // namespace

Image resize_area(const Image& image, int width, int height) {
  const std::vector<AreaTap> columns = area_taps(width, image.width);
  const std::vector<AreaTap> lines = area_taps(height, image.height);
  const int channels = image.channels;
  Image out(width, height, channels);
  for_rows(height, [&](int y) {
    std::vector<float> line(static_cast<std::size_t>(image.width) * channels, 0.0f);
    for (std::size_t k = 0; k < lines[y].weights.size(); ++k) {
      const float* in = image.row(lines[y].first + static_cast<int>(k));
      const float weight = lines[y].weights[k];
      for (std::size_t i = 0; i < line.size(); ++i) line[i] += weight * in[i];
    }
    float* to = out.row(y);
    for (int x = 0; x < width; ++x) {
      const float* from = line.data() + static_cast<std::size_t>(columns[x].first) * channels;
      for (const float weight : columns[x].weights) {
        for (int c = 0; c < channels; ++c) to[x * channels + c] += weight * from[c];
        from += channels;
      }
    }
  });
  return out;
}

LinearTap linear_tap(int out, int out_size, int in_size) {
  const double at = std::clamp((out + 0.5) * in_size / out_size - 0.5, 0.0, in_size - 1.0);
  const int low = std::min(static_cast<int>(at), in_size - 1);
  return {low, std::min(low + 1, in_size - 1), static_cast<float>(at - low)};
}

Image resize_bilinear(const Image& image, int width, int height) {
  std::vector<LinearTap> columns(width);
  for (int x = 0; x < width; ++x) columns[x] = linear_tap(x, width, image.width);
  const int channels = image.channels;
  Image out(width, height, channels);
  for_rows(height, [&](int y) {
    const LinearTap line = linear_tap(y, height, image.height);
    const float* low = image.row(line.low);
    const float* high = image.row(line.high);
    std::vector<float> mixed(static_cast<std::size_t>(image.width) * channels);
    for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] = low[i] + line.weight_of_high * (high[i] - low[i]);
    float* to = out.row(y);
    for (int x = 0; x < width; ++x) {
      const LinearTap& tap = columns[x];
      for (int c = 0; c < channels; ++c) {
        const float a = mixed[tap.low * channels + c];
        to[x * channels + c] = a + tap.weight_of_high * (mixed[tap.high * channels + c] - a);
      }
    }
  });
  return out;
}

}  // namespace dualpixel
