#include "pipeline/portrait/focus.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::pipeline {
namespace {

/// None where the region covers no pixel.
std::optional<double> median_inside(const Image& image, const Face& region, int width, int height) {
  const auto edge = [](double at, int size) {
    return static_cast<int>(std::clamp(std::round(at * size), 0.0, 1.0 * size));
  };
  const int left = edge(region.x / width, image.width), right = edge((region.x + region.width) / width, image.width);
  const int top = edge(region.y / height, image.height);
  const int bottom = edge((region.y + region.height) / height, image.height);
  std::vector<float> values;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) values.push_back(image.at(x, y));
  }
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<double> focus_disparity(const Image& disparity, const std::vector<Face>& faces,
                                      const std::optional<Face>& tap, double in_focus_dp_px, int width, int height) {
  for (const Face& face : faces) {
    const std::optional<double> median = median_inside(disparity, face, width, height);
    if (median && std::abs(*median) <= in_focus_dp_px) return median;
  }
  return tap ? median_inside(disparity, *tap, width, height) : std::nullopt;
}

}  // namespace dualpixel::pipeline
