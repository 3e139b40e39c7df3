#include "evaluation/baselines/match_intervals.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "capture/error.h"
#include "capture/image/rows.h"

namespace dualpixel::evaluation {
namespace {

using Labels = std::uint64_t;  // a bit for each label
using LabelMap = ImageOf<Labels>;

void require(const Image& left, const Image& right, const MatchIntervalOptions& options) {
  const auto whole = [](const char* name, int value, int low, int high, bool odd) {
    if (value >= low && value <= high && (!odd || value % 2 == 1)) return;
    throw InputError(
        fmt::format("match intervals: {}: {}: must be {}{} to {}", name, value, odd ? "odd, " : "", low, high));
  };
  whole("labels", options.labels, 3, 63, true);
  whole("steps_per_dp_px", options.steps_per_dp_px, 1, 64, false);
  whole("window_columns", options.window_columns, 1, 1001, true);
  whole("window_rows", options.window_rows, 1, 1001, true);
  if (left.empty() || left.channels != 1 || right.channels != 1 || !left.same_size(right)) {
    throw InputError(fmt::format("match intervals: views: {} x {} and {} x {}: must be one size, of one channel",
                                 left.width, left.height, right.width, right.height));
  }
}

/// The view between its pixels: cubic convolution (Keys 1981, a = -1/2), the view continued beyond its ends.
float intensity(const float* row, int width, float x) {
  const float inside = std::clamp(x, 0.0f, static_cast<float>(width - 1));
  const int left = std::min(static_cast<int>(inside), std::max(width - 2, 0));
  const float t = inside - static_cast<float>(left);
  const auto at = [&](int i) { return row[std::clamp(left + i, 0, width - 1)]; };
  const float a = at(-1), b = at(0), c = at(1), d = at(2);
  return b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

struct Range {
  float low, high;
};

/// Within half a pixel of the enlarged view about x, in pixels of the view: at the ends and in the middle.
Range range_about(const float* row, int width, float x, float half) {
  const float middle = intensity(row, width, x);
  const float before = intensity(row, width, x - half), after = intensity(row, width, x + half);
  return {std::min({before, middle, after}), std::max({before, middle, after})};
}

LabelMap labels_that_match(const Image& left, const Image& right, const MatchIntervalOptions& options) {
  LabelMap map(left.width, left.height);
  const float half = 0.5f / static_cast<float>(options.steps_per_dp_px);
  for_rows(left.height, [&](int y) {
    for (int x = 0; x < left.width; ++x) {
      const auto at = static_cast<float>(x);
      const Range own = range_about(left.row(y), left.width, at, half);
      Labels bits = 0;
      for (int k = 0; k < options.labels; ++k) {
        const Range other = range_about(right.row(y), right.width, at + options.dp_px_of(static_cast<float>(k)), half);
        const float gap = std::max(own.low - other.high, other.low - own.high);
        if (gap <= options.noise_levels) bits |= Labels{1} << k;
      }
      map.row(y)[x] = bits;
    }
  });
  return map;
}

/// Bits that all pixels of the window have; windows end at the border.
LabelMap common_labels(const LabelMap& map, int columns, int rows) {
  LabelMap along(map.width, map.height), out(map.width, map.height);
  for_rows(map.height, [&](int y) {
    for (int x = 0; x < map.width; ++x) {
      Labels bits = ~Labels{0};
      for (int u = std::max(x - columns / 2, 0); u <= std::min(x + columns / 2, map.width - 1); ++u) {
        bits &= map.row(y)[u];
      }
      along.row(y)[x] = bits;
    }
  });
  for_rows(map.height, [&](int y) {
    for (int x = 0; x < map.width; ++x) {
      Labels bits = ~Labels{0};
      for (int v = std::max(y - rows / 2, 0); v <= std::min(y + rows / 2, map.height - 1); ++v) {
        bits &= along.row(v)[x];
      }
      out.row(y)[x] = bits;
    }
  });
  return out;
}

}  // namespace

MatchIntervals match_intervals(const Image& left, const Image& right, const MatchIntervalOptions& options) {
  require(left, right, options);
  const LabelMap map =
      common_labels(labels_that_match(left, right, options), options.window_columns, options.window_rows);
  MatchIntervals intervals{Image(left.width, left.height), Image(left.width, left.height)};
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    const Labels bits = map.data[i];
    intervals.first.data[i] = bits == 0 ? 0.0f : static_cast<float>(std::countr_zero(bits));
    intervals.last.data[i] = static_cast<float>(bits == 0 ? options.labels - 1 : 63 - std::countl_zero(bits));
  }
  return intervals;
}

}  // namespace dualpixel::evaluation
