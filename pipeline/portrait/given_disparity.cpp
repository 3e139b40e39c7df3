#include "pipeline/portrait/given_disparity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/error.h"
#include "pipeline/disparity/likelihood/options.h"

namespace dualpixel::pipeline {
namespace {

void require_given_map(const Image& map, int width, int height, const std::string& name) {
  if (map.width == width && map.height == height && map.channels == 1) return;
  throw InputError(fmt::format("{}: {} x {} pixels of {} channel{}: must be one channel of {} x {}, as the views are",
                               name, map.width, map.height, map.channels, map.channels == 1 ? "" : "s", width, height));
}

void require_given_values(const Image& map, float most, const char* range, const std::string& name) {
  const auto outside = std::find_if(map.data.begin(), map.data.end(), [&](float v) { return v < 0 || v > most; });
  if (outside == map.data.end()) return;
  const auto i = static_cast<int>(outside - map.data.begin());
  throw InputError(
      fmt::format("{}: pixel ({}, {}): {:g}: must lie in {}", name, i % map.width, i / map.width, *outside, range));
}

}  // namespace

PixelDisparity as_matched(const GivenDisparity& given, int width, int height) {
  require_given_map(given.disparity_dp_px, width, height, given.disparity_name);
  const bool has_confidence = !given.confidence.empty(), has_sigma = !given.sigma_dp_px.empty();
  if (has_confidence) {
    require_given_map(given.confidence, width, height, given.confidence_name);
    require_given_values(given.confidence, 1, "[0, 1]", given.confidence_name);
  }
  if (has_sigma) {
    require_given_map(given.sigma_dp_px, width, height, given.sigma_name);
    require_given_values(given.sigma_dp_px, std::numeric_limits<float>::infinity(), "[0, inf]", given.sigma_name);
  }
  const float half_sure = LikelihoodMatchOptions().confident_sigma_dp_px;
  const auto confidence_at = [&](std::size_t i) {
    if (has_confidence) return std::isfinite(given.confidence.data[i]) ? given.confidence.data[i] : 0.0f;
    if (!has_sigma) return 1.0f;
    const float ratio = given.sigma_dp_px.data[i] / half_sure;
    return std::isfinite(ratio) ? 1 / (1 + ratio * ratio) : 0.0f;
  };
  PixelDisparity matched{given.disparity_dp_px, Image(width, height), given.sigma_dp_px};
  for (std::size_t i = 0; i < matched.disparity_dp_px.data.size(); ++i) {
    float& disparity = matched.disparity_dp_px.data[i];
    if (std::isfinite(disparity)) {
      matched.confidence.data[i] = confidence_at(i);
    } else {
      disparity = 0;
    }
  }
  return matched;
}

}  // namespace dualpixel::pipeline
