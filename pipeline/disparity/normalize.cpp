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
    for (int x = 0; x < width; ++x) {
      double sum = 0, square = 0;
      for (int k = 0; k <= 2 * reach; ++k) {
        sum += sums[x + k];
        square += squares[x + k];
      }
      const int columns = std::min(x + reach, width - 1) - std::max(x - reach, 0) + 1;
      const double count = static_cast<double>(columns) * (bottom - top + 1);
      const double mean = sum / count;
      const double deviation = std::sqrt(std::max(square / count - mean * mean, 0.0));
      out.row(y)[x] = static_cast<float>((finite(view.row(y)[x]) - mean) / (deviation + options.std_floor));
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
