#include "pipeline/disparity/paper/normalize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/error.h"
#include "capture/image/rows.h"

namespace dualpixel::pipeline {

OptionFields fields(NormalizeOptions& options) {
  return {{"window_px", &options.window_px, 3, 255, "DP px, odd", "S: 9"},
          {"std_floor", &options.std_floor, 1e-9, 1, "normalized signal", "S: 0.001"},
          {"clipped", &options.clipped, 0, 1e6, "of the views' white", "ours"}};
}

void check(const NormalizeOptions& options) {
  check_options("normalize", options);
  if (options.window_px % 2 == 0) {
    throw InputError(fmt::format("normalize.window_px: {}: must be odd", options.window_px));
  }
}

Image normalize_locally(const Image& view, const NormalizeOptions& options) {
  check(options);
  const int reach = options.window_px / 2;
  const int width = view.width;
  Image out(width, view.height);
  const auto finite = [](float value) { return std::isfinite(value) ? value : 0.0f; };
  const auto add_line = [&](int line, double sign, std::vector<double>& sums, std::vector<double>& squares) {
    const float* row = view.row(line);
    for (int x = 0; x < width; ++x) {
      const double value = finite(row[x]);
      sums[x + reach] += sign * value;
      squares[x + reach] += sign * value * value;
    }
  };
  // Bands of rows, each with its own running sums: the answer does not depend on how many threads there are.
  constexpr int kBand = 16;
  for_rows((view.height + kBand - 1) / kBand, [&](int band) {
    // In double: the variance is a small difference of large numbers. Zeros stand for what lies outside.
    std::vector<double> sums(width + 2 * reach), squares(width + 2 * reach), sum(width), square(width);
    const int first = band * kBand;
    for (int line = std::max(first - reach, 0); line < std::min(first + reach, view.height); ++line) {
      add_line(line, 1, sums, squares);
    }
    for (int y = first; y < std::min(first + kBand, view.height); ++y) {
      const int top = std::max(y - reach, 0);
      const int bottom = std::min(y + reach, view.height - 1);
      if (y + reach < view.height) add_line(y + reach, 1, sums, squares);
      if (y > first && y - reach > 0) add_line(y - reach - 1, -1, sums, squares);
      // Columns of the window outermost, so that pixels are independent of each other: these loops become vectors.
      for (int x = 0; x < width; ++x) {
        sum[x] = sums[x + 2 * reach];
        square[x] = squares[x + 2 * reach];
      }
      for (int k = 0; k < 2 * reach; k += 2) {
        for (int x = 0; x < width; ++x) {
          sum[x] += sums[x + k] + sums[x + k + 1];
          square[x] += squares[x + k] + squares[x + k + 1];
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
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
