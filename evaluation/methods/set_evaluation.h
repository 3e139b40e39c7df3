#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/methods/disparity_method.h"
#include "evaluation/methods/set_samples.h"

/// Methods compared over a set of pairs whose disparity is known.
namespace dualpixel::evaluation {

/// Parts of the views, by truth and left view. Edges: up to 2 DP px from a jump of the true disparity by more than 0.1.
/// Thin: no more than 8 DP px along the row or the column, with what lies further back by such a jump on both sides.
/// Textureless: the variance over 9 x 9 pixels is less than twice that of the noise that the sensor states (none where
/// it states none). Clipped: either view reaches 0.98 of its white. Front and behind: the true disparity is under
/// -0.25, or over 0.25; the bins are of its amount, DP px.
std::vector<std::string> region_names();

/// Over all pixels of a region in all samples.
struct SetFigures {
  std::size_t pixels = 0;                  ///< with known truth
  double found = 0;                        ///< share of them with a finite disparity
  std::optional<double> rmse_dp_px;        ///< of those; none where there are none, as the next
  std::optional<double> wrong;             ///< share of all that err by more than 0.5 DP px, or were not found
  std::optional<double> within_one_sigma;  ///< of those found that were given a sigma; none where none was
};

struct SetScore {
  std::string method;
  std::vector<SetFigures> regions;  ///< in the order of region_names()
  double wall_s = 0, cpu_s = 0;     ///< mean of a pair
  std::optional<double> peak_rss_mb;
};

/// Each pair is read once and given to each method. Throws InputError.
std::vector<SetScore> evaluate_set(const std::vector<std::string>& sample_folders,
                                   const std::vector<DisparityMethod>& methods,
                                   const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const std::vector<SetScore>& scores, std::size_t samples);
/// One table a figure, which a click on a column's head sorts.
std::string to_page(const std::vector<SetScore>& scores, std::size_t samples);
/// For a terminal: a line a method.
std::string to_text(const std::vector<SetScore>& scores);

}  // namespace dualpixel::evaluation
