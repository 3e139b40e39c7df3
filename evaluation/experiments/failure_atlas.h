#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/experiments/failure_cases.h"
#include "evaluation/methods/disparity_method.h"

/// How each method fails on the cases of failure_cases.h, and whether its confidence shows it.
namespace dualpixel::evaluation {

/// Of the pixels' errors relative to the sigma that the method predicts. Shares of pixels.
struct SigmaFigures {
  double confident = 0;             ///< predicted sigma under 0.2 DP px
  double overconfident_errors = 0;  ///< wrong, and confident
  double median_sigma_dp_px = 0;
  double within_one_sigma = 0, within_two_sigma = 0;
};

/// Over pixels that lie 2 tiles inside and whose truth is finite.
struct FailureFigures {
  std::optional<double> rmse_dp_px;   ///< of the pixels with a finite disparity; none where there are none
  double wrong = 0;                   ///< share of pixels that err by more than 0.5 DP px, or have no disparity
  std::optional<double> confidence;   ///< mean; none where the method has none
  std::optional<SigmaFigures> sigma;  ///< none where the method predicts no sigma
};
FailureFigures measure_failure(const FailureCase& failure, const DisparityMethod& method);

struct FailureStep {
  double value = 0;                     ///< of the swept quantity
  std::vector<FailureFigures> methods;  ///< in the order of the sweep's names
};

struct FailureSweep {
  FailureRow row;
  std::vector<std::string> methods;  ///< names
  std::vector<FailureStep> steps;

  /// The first value at which more than a tenth of the pixels are wrong; none where that never happens.
  std::optional<double> breaks_at(std::size_t method) const;
};

std::vector<FailureSweep> measure_failures(const std::vector<DisparityMethod>& methods,
                                           const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const std::vector<FailureSweep>& sweeps);
std::string to_page(const std::vector<FailureSweep>& sweeps);

}  // namespace dualpixel::evaluation
