#include "evaluation/experiments/failure_atlas.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/metrics/disparity_metrics.h"
#include "evaluation/metrics/statistics.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kBorder = 16;  // 2 tiles
constexpr double kBrokenShare = 0.1;

nlohmann::ordered_json to_json(const FailureFigures& figures) {
  nlohmann::ordered_json json;
  if (figures.rmse_dp_px) json["rmse_dp_px"] = *figures.rmse_dp_px;
  json["wrong_share"] = figures.wrong;
  if (figures.confidence) json["mean_confidence"] = *figures.confidence;
  if (!figures.sigma) return json;
  json["confident_share"] = figures.sigma->confident;
  json["overconfident_error_share"] = figures.sigma->overconfident_errors;
  json["median_sigma_dp_px"] = figures.sigma->median_sigma_dp_px;
  json["within_one_sigma_share"] = figures.sigma->within_one_sigma;
  json["within_two_sigma_share"] = figures.sigma->within_two_sigma;
  return json;
}

nlohmann::ordered_json to_json(const FailureSweep& sweep) {
  nlohmann::ordered_json breaks, steps = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < sweep.methods.size(); ++i) {
    const std::optional<double> value = sweep.breaks_at(i);
    breaks[sweep.methods[i]] = value ? fmt::format("{:g}", *value) : "never";
  }
  for (const FailureStep& step : sweep.steps) {
    nlohmann::ordered_json json = {{sweep.row.key, step.value}};
    for (std::size_t i = 0; i < step.methods.size(); ++i) json[sweep.methods[i]] = to_json(step.methods[i]);
    steps.push_back(json);
  }
  return {{"name", sweep.row.name}, {"title", sweep.row.title}, {"breaks_at", breaks}, {"steps", steps}};
}

}  // namespace

FailureFigures measure_failure(const FailureCase& failure, const DisparityMethod& method) {
  const pipeline::PixelDisparity found = method.run(failure.left, failure.right, {failure.noise}).found;
  FailureFigures figures;
  SigmaFigures of_sigma;
  std::vector<float> sigmas;
  double count = 0, finite = 0, squares = 0, confidence = 0;
  for (int y = kBorder; y < kFailureHeight - kBorder; ++y) {
    for (int x = kBorder; x < kFailureWidth - kBorder; ++x) {
      const float truth = failure.truth_dp_px.at(x, y);
      if (!std::isfinite(truth)) continue;
      const float error = std::abs(found.disparity_dp_px.at(x, y) - truth);
      const bool wrong = !(error <= kWrongDpPx);
      count += 1;
      if (std::isfinite(error)) {
        finite += 1;
        squares += static_cast<double>(error) * error;
      }
      figures.wrong += wrong;
      if (!found.confidence.empty()) confidence += found.confidence.at(x, y);
      if (found.sigma_dp_px.empty()) continue;
      const float sigma = found.sigma_dp_px.at(x, y);
      sigmas.push_back(sigma);
      of_sigma.confident += sigma < kConfidentDpPx;
      of_sigma.overconfident_errors += wrong && sigma < kConfidentDpPx;
      of_sigma.within_one_sigma += error < sigma;
      of_sigma.within_two_sigma += error < 2 * sigma;
    }
  }
  if (finite > 0) figures.rmse_dp_px = std::sqrt(squares / finite);
  figures.wrong /= count;
  if (!found.confidence.empty()) figures.confidence = confidence / count;
  if (sigmas.empty()) return figures;
  for (double* share :
       {&of_sigma.confident, &of_sigma.overconfident_errors, &of_sigma.within_one_sigma, &of_sigma.within_two_sigma}) {
    *share *= 1 / count;
  }
  of_sigma.median_sigma_dp_px = median(std::move(sigmas));
  figures.sigma = of_sigma;
  return figures;
}

std::optional<double> FailureSweep::breaks_at(std::size_t method) const {
  for (const FailureStep& step : steps) {
    if (step.methods[method].wrong > kBrokenShare) return step.value;
  }
  return {};
}

std::vector<FailureSweep> measure_failures(const std::vector<DisparityMethod>& methods,
                                           const std::function<void(double)>& progress) {
  std::vector<FailureSweep> sweeps;
  std::vector<std::string> names;
  for (const DisparityMethod& method : methods) names.push_back(method.name);
  const std::vector<FailureRow> rows = failure_rows();
  for (const FailureRow& row : rows) {
    FailureSweep& sweep = sweeps.emplace_back(FailureSweep{row, names, {}});
    for (const double value : row.values) {
      const FailureCase failure = row.make(value);
      FailureStep& step = sweep.steps.emplace_back(FailureStep{value, {}});
      for (const DisparityMethod& method : methods) step.methods.push_back(measure_failure(failure, method));
    }
    if (progress) progress(static_cast<double>(sweeps.size()) / static_cast<double>(rows.size()));
  }
  return sweeps;
}

nlohmann::ordered_json to_json(const std::vector<FailureSweep>& sweeps) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const FailureSweep& sweep : sweeps) rows.push_back(to_json(sweep));
  return {{"format", "dualpixel-experiment-failures"}, {"version", 1}, {"rows", rows}};
}

}  // namespace dualpixel::evaluation
