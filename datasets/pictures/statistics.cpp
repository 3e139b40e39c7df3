#include "datasets/pictures/statistics.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "capture/image/display.h"
#include "capture/image/resample.h"

namespace dualpixel::datasets {
namespace {

/// Calls visit(index) for every n-th pixel of every n-th row, n up to 4, smaller where the picture is.
template <typename Visit>
void each_probe(const Image& image, const Visit& visit) {
  constexpr int kFewest = 64;  // a side
  const int step = std::clamp(std::min(image.width, image.height) / kFewest, 1, 4);
  for (int y = 0; y < image.height; y += step) {
    for (int x = 0; x < image.width; x += step) visit(static_cast<std::size_t>(y) * image.width + x);
  }
}

/// Six digits are enough.
double six_digit_number(double value) {
  if (value == 0) return 0;
  const double unit = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  return std::round(value * unit) / unit;
}

nlohmann::ordered_json quantiles(std::vector<float> values) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  if (values.empty()) return out;
  std::sort(values.begin(), values.end());
  for (int i = 0; i < kQuantiles; ++i) {
    const double at = static_cast<double>(values.size() - 1) * i / (kQuantiles - 1);
    out.push_back(six_digit_number(values[static_cast<std::size_t>(std::lround(at))]));
  }
  return out;
}

}  // namespace

nlohmann::ordered_json statistics_of(const Capture& capture) {
  const Truth& truth = *capture.truth;
  std::vector<float> disparity, depth;
  double count = 0, people = 0;
  each_probe(truth.depth_m, [&](std::size_t i) {
    disparity.push_back(truth.disparity_dp_px.data[i]);
    if (truth.valid.data[i] > 0) depth.push_back(truth.depth_m.data[i]);
    people += truth.person_mask.data[i];
    ++count;
  });
  const Image left = normalized(capture.frames.front().left, capture.exposure);
  const Image right = normalized(capture.frames.front().right, capture.exposure);
  // noise and fixed pattern leave full wells a little below
  const double full = 0.98 * std::min({1.0, mosaic_white(capture.exposure), 2 * view_white(capture.exposure)});
  double sum = 0, clipped = 0;
  const auto pixels = static_cast<double>(left.data.size());
  for (std::size_t i = 0; i < left.data.size(); ++i) {
    const float signal = left.data[i] + right.data[i];
    sum += std::min(signal, 1.0f);
    clipped += signal >= full ? 1 : 0;
  }
  const double valid_share = static_cast<double>(depth.size()) / count;
  return {{"disparity_dp_px", quantiles(std::move(disparity))}, {"depth_m", quantiles(std::move(depth))},
          {"valid_share", six_digit_number(valid_share)},       {"person_share", six_digit_number(people / count)},
          {"mean_signal", six_digit_number(sum / pixels)},      {"clipped_share", six_digit_number(clipped / pixels)}};
}

Image preview_of(const Capture& capture) {
  constexpr int kWidest = 160;
  Image sum = capture.truth->left;
  for (std::size_t i = 0; i < sum.data.size(); ++i) sum.data[i] += capture.truth->right.data[i];
  const int width = std::min(kWidest, sum.width);
  return encode_for_display(resize_area(sum, width, std::max(1, sum.height * width / sum.width)));
}

}  // namespace dualpixel::datasets
