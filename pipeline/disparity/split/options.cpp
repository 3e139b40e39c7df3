#include "pipeline/disparity/split/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/error.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kLeastAlpha = 0.02f, kHardAlpha = 0.4245f;

}  // namespace

float alpha_of_camera(float alpha) {
  constexpr float kMost = 0.6f;  // halves split beside the middle of the pixel
  return alpha >= kLeastAlpha && alpha <= kMost ? std::min(alpha, kHardAlpha) : 0;
}

OptionFields fields(SplitMatchOptions& options) {
  return {{"range_px", &options.range_px, 4, 64, "DP px", "ours"},
          {"alpha", &options.alpha, 0, kHardAlpha, "", "ours; 0: the capture's, a hard split's, or 0.21"},
          {"clipped", &options.clipped, 0, 1e6, "of the views' white", "ours"},
          {"low_pass_px", &options.low_pass_px, 4, 64, "DP px", "ours"},
          {"high_pass_px", &options.high_pass_px, 8, 256, "DP px", "ours"},
          {"window_px", &options.window_px, 4, 64, "DP px", "ours"},
          {"near_focus_dp_px", &options.near_focus_dp_px, 0, 4, "DP px", "ours"},
          {"confident_sigma_dp_px", &options.confident_sigma_dp_px, 1e-6, 1e6, "DP px", "ours"}};
}

void check(const SplitMatchOptions& options) {
  check_options("split_match", options);
  if (options.alpha != 0 && options.alpha < kLeastAlpha) {
    throw InputError(
        fmt::format("split_match.alpha: {}: must be 0 or in [{}, {}]", options.alpha, kLeastAlpha, kHardAlpha));
  }
}

}  // namespace dualpixel::pipeline
