#include "pipeline/disparity/likelihood/options.h"

#include <fmt/format.h>

#include <cmath>

#include "capture/error.h"

namespace dualpixel::pipeline {

OptionFields fields(LikelihoodMatchOptions& options) {
  return {{"range_px", &options.range_px, 2, 64, "DP px", "ours"},
          {"clipped", &options.clipped, 0, 1e6, "of the views' white", "ours"},
          {"offset_search", &options.offset_search, 1e-6, 1, "of the signal", "ours"},
          {"offset", &options.offset, 1e-6, 1, "of the signal", "ours"},
          {"model_error", &options.model_error, 0, 1, "of the cost's contrast", "ours"},
          {"neighbor_weight", &options.neighbor_weight, 0, 1, "", "ours"},
          {"confident_sigma_dp_px", &options.confident_sigma_dp_px, 1e-6, 1e6, "DP px", "ours"}};
}

void check(const LikelihoodMatchOptions& options) {
  check_options("likelihood_match", options);
  if (!options.noise) return;
  const ViewNoise& noise = *options.noise;
  if (!(noise.shot >= 0 && noise.read >= 0 && noise.shot + noise.read < INFINITY)) {
    throw InputError(fmt::format("likelihood_match.noise: shot {}, read {}: must be finite and not negative",
                                 noise.shot, noise.read));
  }
}

}  // namespace dualpixel::pipeline
