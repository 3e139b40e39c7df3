#pragma once
#include <functional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/disparity/noise_model.h"

/// The ways in which matching two DP views fails, each swept until it does: views made in closed form, or as the mean
/// over points of the pupil of what each point sees, so that the truth is exact.
namespace dualpixel::evaluation {

/// Linear views, normalised signal, noise added; and what a matcher should find.
struct FailureCase {
  Image left, right;
  Image truth_dp_px;  ///< centroid disparity of what each pixel sees; NaN where that is no one surface
  pipeline::ViewNoise noise;
};

struct FailureRow {
  std::string name;  ///< a word: key in the JSON
  std::string title;
  std::string sweep;           ///< what `values` mean, with unit
  std::string key;             ///< the same as a key, with unit
  std::vector<double> values;  ///< from harmless to hopeless
  std::function<FailureCase(double value)> make;
  bool log = false;  ///< values are charted on a logarithmic axis
};

/// Each case is kFailureWidth x kFailureHeight DP pixels, of mean 0.25 and with the noise of 100 lux (811 electrons a
/// pixel) unless its row says otherwise. Textures have as much contrast in every octave ("1/f").
std::vector<FailureRow> failure_rows();
inline constexpr int kFailureWidth = 384, kFailureHeight = 192;

/// What one method makes of a case, over pixels that lie 2 tiles inside and whose truth is finite.
struct FailureFigures {
  double rmse_dp_px = 0;
  double wrong = 0;       ///< share of pixels that err by more than 0.5 DP px
  double confidence = 0;  ///< mean
  double sure = 0;        ///< share of pixels with a predicted sigma under 0.2 DP px; NaN: predicts none
  double deceived = 0;    ///< share of pixels that are wrong and sure
  double median_sigma_dp_px = 0;
  double within_one_sigma = 0, within_two_sigma = 0;  ///< share of errors
};
enum class FailureMethod { paper, likelihood };
FailureFigures measure_failure(const FailureCase& failure, FailureMethod method);

}  // namespace dualpixel::evaluation
