#include "evaluation/baselines/bilateral_space_stereo.h"

#include <algorithm>
#include <cmath>

#include "pipeline/edge_aware/guide.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kReference_px = 2688;

int odd_near(double size, int least) { return std::max(2 * static_cast<int>(std::lround((size - 1) / 2)) + 1, least); }

/// Both by the same gain.
Image encoded(const Image& view, float gain) {
  Image out = view;
  for (float& value : out.data) value = 255 * std::sqrt(std::clamp(gain * value, 0.0f, 1.0f));
  return out;
}

/// Each pixel that of the view's pixel that covers its center.
Image spread(const Image& view, int width, int height) {
  Image out(width, height);
  for (int y = 0; y < height; ++y) {
    const float* from = view.row(static_cast<int>((y + 0.5) * view.height / height));
    for (int x = 0; x < width; ++x) out.row(y)[x] = from[static_cast<int>((x + 0.5) * view.width / width)];
  }
  return out;
}

}  // namespace

Image bilateral_space_stereo(const Image& left, const Image& right, const Image& linear_rgb,
                             const BilateralSpaceStereoOptions& options) {
  const int width = linear_rgb.width, height = linear_rgb.height;
  const double scale = width / kReference_px;
  MatchIntervalOptions match = options.match;
  const double range_dp_px = std::max(options.range_dp_px * scale, 1.0);
  match.steps_per_dp_px = std::clamp(static_cast<int>(31 / range_dp_px), 1, match.steps_per_dp_px);
  match.labels = 2 * static_cast<int>(std::lround(range_dp_px * match.steps_per_dp_px)) + 1;
  match.window_columns = odd_near(options.window_px * scale * left.width / width, match.window_columns);
  match.window_rows = odd_near(options.window_px * scale * left.height / height, match.window_rows);

  const float gain = 2 * pipeline::guide_gain(linear_rgb);  // a view has half of the light
  const MatchIntervals found = match_intervals(encoded(left, gain), encoded(right, gain), match);
  const MatchIntervals intervals{spread(found.first, width, height), spread(found.last, width, height)};
  const Image guide = pipeline::encode_guide(linear_rgb, pipeline::guide_gain(linear_rgb));
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(
      guide, {std::max(static_cast<float>(options.cell_px * scale), 1.0f), options.cell_luma, options.cell_chroma});
  const std::vector<double> labels = solve_bilateral_space(grid, intervals, match.labels, options.solve);
  Image disparity = pipeline::interpolate(grid, guide, std::vector<float>(labels.begin(), labels.end()), 1);
  for (float& label : disparity.data) label = match.dp_px_of(label);
  return disparity;
}

}  // namespace dualpixel::evaluation
