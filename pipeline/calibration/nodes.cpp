#include "pipeline/calibration/nodes.h"

#include <algorithm>

namespace dualpixel::pipeline {

Image node_image(float fill) { return Image(kCalibrationColumns, kCalibrationRows, 1, fill); }

NodeInterval node_interval(double fraction, int count) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (count - 1);
  const int first = std::min(static_cast<int>(at), count - 2);
  return {first, static_cast<float>(at - first)};
}

std::array<float, 4> cubic_over(const float* nodes, int stride, int count, int first) {
  const float at = nodes[first * stride], next = nodes[(first + 1) * stride];
  const float before = first > 0 ? nodes[(first - 1) * stride] : 3 * at - 3 * next + nodes[(first + 2) * stride];
  const float after = first + 2 < count ? nodes[(first + 2) * stride] : 3 * next - 3 * at + nodes[(first - 1) * stride];
  return {at, 0.5f * (next - before), before - 2.5f * at + 2 * next - 0.5f * after,
          0.5f * (after - before) + 1.5f * (at - next)};
}

std::array<float, kCalibrationColumns> node_row(const Image& nodes, const NodeInterval& height) {
  std::array<float, kCalibrationColumns> row{};
  for (int i = 0; i < kCalibrationColumns; ++i) {
    row[i] = evaluate(cubic_over(nodes.data.data() + i, kCalibrationColumns, kCalibrationRows, height.first), height.t);
  }
  return row;
}

double bicubic(const Image& nodes, double x, double y) {
  const auto row = node_row(nodes, node_interval(y, kCalibrationRows));
  const NodeInterval column = node_interval(x, kCalibrationColumns);
  return evaluate(cubic_over(row.data(), 1, kCalibrationColumns, column.first), column.t);
}

void fill_holes(const Image& known, Image& nodes) {
  Image filled = known;
  for (bool more = true; more;) {
    more = false;
    const Image before = filled;
    for (int j = 0; j < nodes.height; ++j) {
      for (int i = 0; i < nodes.width; ++i) {
        if (before.at(i, j) != 0) continue;
        float sum = 0, count = 0;
        for (int y = std::max(j - 1, 0); y <= std::min(j + 1, nodes.height - 1); ++y) {
          for (int x = std::max(i - 1, 0); x <= std::min(i + 1, nodes.width - 1); ++x) {
            if (before.at(x, y) != 0) sum += nodes.at(x, y), ++count;
          }
        }
        if (count == 0) continue;
        nodes.at(i, j) = sum / count;
        filled.at(i, j) = 1;
        more = true;
      }
    }
  }
}

}  // namespace dualpixel::pipeline
