#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/failures/failure_row.h"
#include "evaluation/methods/disparity_method.h"

/// How each method fails on a row's cases, and whether its confidence shows it.
namespace dualpixel::evaluation {

/// Over pixels that lie 2 tiles inside and whose truth is finite; shares of them. A pixel is wrong where it errs by
/// more than 0.5 DP px or has no disparity. It is trusted where a sigma under 0.2 DP px was predicted, or, by a method
/// without sigma, a confidence of 1/2 or more.
struct FailureFigures {
  double wrong = 0;
  std::optional<double> rmse_dp_px;      ///< of the pixels with a finite disparity; none where there are none
  std::optional<double> confidence;      ///< mean; none where the method has none
  std::optional<double> trusted;         ///< none, as the next, where the method has neither
  std::optional<double> overconfident;   ///< wrong and trusted
  std::optional<double> sigma_dp_px;     ///< median of what was predicted; none, as the next, where nothing was
  std::optional<double> error_68_dp_px;  ///< what 68.27 % of the errors stay under: the sigma that is true
  std::optional<double> within_one_sigma, within_two_sigma;  ///< of the pixels with a sigma
};

/// One step of a row.
struct FailureStep {
  double value = 0;                     ///< of the swept quantity
  std::vector<FailureFigures> methods;  ///< in the order of the sweep's names
  /// The left view, and the disparity that is true and that each method finds: JPEG files as data URIs.
  std::string view_uri, truth_uri;
  std::vector<std::string> found_uris;
};

/// Steps of the row; steps.size(): it holds throughout.
struct BreakingPoint {
  std::size_t step = 0;           ///< the first at which more than a tenth of the pixels are wrong
  std::size_t low = 0, high = 0;  ///< its 95 % interval: of squares of 16 x 16 pixels drawn anew (bootstrap)
};

struct FailureSweep {
  std::string name, title, sweep, key, note;  ///< FailureRow's
  bool log = false;
  double limit_dp_px = 0;             ///< of the colors of its maps
  std::vector<std::string> methods;   ///< names
  std::vector<BreakingPoint> breaks;  ///< of each
  std::vector<FailureStep> steps;

  /// Where a breaking point's step is, as text; "never" at the end.
  std::string value_at(std::size_t step) const;
  /// The most wrong and trusted of any step; none where the method says nothing of its errors.
  std::optional<double> overconfident(std::size_t method) const;
};

FailureFigures measure_failure(const ViewSample& views, const DisparityMethod& method);

/// `draws`: how many textures and noises each figure is of.
FailureSweep measure_row(const FailureRow& row, const std::vector<DisparityMethod>& methods, unsigned draws,
                         const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const FailureSweep& sweep, bool with_pictures);
/// What to_json() with pictures gave.
FailureSweep sweep_of_json(const nlohmann::ordered_json& json);

/// A table of methods and failures, whose cells lead to the curves and pictures. `camera`: a line on what took them.
std::string to_page(const std::vector<FailureSweep>& sweeps, const std::string& camera);

}  // namespace dualpixel::evaluation
