#include "pipeline/disparity/normalize.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/rows.h"

namespace dualpixel::pipeline {

Image normalize_locally(const Image& view, const NormalizeOptions& options) {
  const int reach = options.window_px / 2;
  const int width = view.width;
  Image out(width, view.height);
  const auto finite = [](float value) { return std::isfinite(value) ? value : 0.0f; };
  for_rows(view.height, [&](int y) {
    const int top = std::max(y - reach, 0);
    const int bottom = std::min(y + reach, view.height - 1);
    // Column sums in double: the variance is a small difference of large numbers. Zeros stand for what lies outside.
    std::vector<double> sums(width + 2 * reach), squares(width + 2 * reach);
    for (int line = top; line <= bottom; ++line) {
      const float* row = view.row(line);
      for (int x = 0; x < width; ++x) {
        const double value = finite(row[x]);
        sums[x + reach] += value;
        squares[x + reach] += value * value;
      }
    }
    // Sums over the window, columns outermost so that pixels are independent of each other: these loops become vectors.
    std::vector<double> sum(width), square(width);
    for (int k = 0; k <= 2 * reach; ++k) {
      for (int x = 0; x < width; ++x) {
        sum[x] += sums[x + k];
        square[x] += squares[x + k];
      }
    }
    const float* in = view.row(y);
    float* to = out.row(y);
    for (int x = 0; x < width; ++x) {
      const int columns = std::min(x + reach, width - 1) - std::max(x - reach, 0) + 1;
      const double share = 1 / (static_cast<double>(columns) * (bottom - top + 1));
      const double mean = sum[x] * share;
      const float deviation = std::sqrt(static_cast<float>(std::max(square[x] * share - mean * mean, 0.0)));
      to[x] = static_cast<float>(finite(in[x]) - mean) / (deviation + options.std_floor);
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
