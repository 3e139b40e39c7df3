#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/benchmarks/stereo_method.h"

/// Matchers against true disparity on rendered pairs: error, and time.
namespace dualpixel::evaluation {

/// The pipeline's matchers, then OpenCV's where the build has them.
std::vector<StereoMethod> stereo_methods();

/// How well a confidence sorts the errors.
struct ConfidenceQuality {
  double area_over_oracle = 0;  ///< area under the sparsification curve over that of an oracle; 1 is perfect
  std::optional<double> ause;   ///< none where every error is 0
};

/// How well a predicted sigma describes the errors; shares of the pixels.
struct SigmaQuality {
  double area_of_exact_sigma = 0;  ///< area_over_oracle, were every error drawn from its predicted sigma
  double within_one_sigma = 0, within_two_sigma = 0;
  double overconfident_errors = 0;  ///< err by more than 0.5 DP px with a sigma under 0.2
};

struct MatcherBenchmark {
  std::string method;
  double ms = 0;              ///< at 1344 x 1008, all threads, the best of nine
  double memory_mb = 0;       ///< at most, besides the views
  double answered_share = 0;  ///< of the pixels with truth; errors are over these
  double rmse_dp_px = 0;
  double wrong_share = 0;  ///< err by more than 0.5 DP px
  double aiwe1_dp_px = 0;
  std::optional<ConfidenceQuality> confidence;
  std::optional<SigmaQuality> sigma;
};

struct DisparityBenchmark {
  struct Scene {
    std::string scene;  ///< file
    std::vector<MatcherBenchmark> methods;
  };
  double copy_ms = 0;  ///< of 1344 x 1008 floats, read and written once
  std::vector<Scene> scenes;
};

DisparityBenchmark measure_disparity(const std::vector<std::string>& scene_files);

nlohmann::ordered_json to_json(const DisparityBenchmark& benchmark);
std::string to_page(const DisparityBenchmark& benchmark);

}  // namespace dualpixel::evaluation
