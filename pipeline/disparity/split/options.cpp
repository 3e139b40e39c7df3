#include "pipeline/disparity/split/options.h"

namespace dualpixel::pipeline {

OptionFields fields(SplitMatchOptions& options) {
  return {{"range_px", &options.range_px, 4, 64, "DP px", "ours"},
          {"alpha", &options.alpha, 0.02, 0.25, "", "ours"},
          {"clipped", &options.clipped, 0, 1e6, "of the views' white", "ours"},
          {"low_pass_px", &options.low_pass_px, 4, 64, "DP px", "ours"},
          {"high_pass_px", &options.high_pass_px, 8, 256, "DP px", "ours"},
          {"window_px", &options.window_px, 4, 64, "DP px", "ours"},
          {"near_focus_dp_px", &options.near_focus_dp_px, 0, 4, "DP px", "ours"},
          {"confident_sigma_dp_px", &options.confident_sigma_dp_px, 1e-6, 1e6, "DP px", "ours"}};
}

void check(const SplitMatchOptions& options) { check_options("split_match", options); }

}  // namespace dualpixel::pipeline
