#pragma once
#include <functional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/disparity/noise_model.h"

/// Pairs of views on which matching fails, each kind swept from harmless to hopeless. Views are made in closed form, or
/// as the mean over points of the pupil of the view from each point, so that the truth is exact.
namespace dualpixel::evaluation {

/// Linear views, normalized signal, noise added; and the true disparity.
struct FailureCase {
  Image left, right;
  Image truth_dp_px;  ///< centroid disparity of the visible surface; NaN where a pixel sees more than one
  pipeline::ViewNoise noise;
};

struct FailureRow {
  std::string name;  ///< key in the JSON
  std::string title;
  std::string sweep;           ///< the swept quantity, with unit
  std::string key;             ///< the same as a key, with unit
  std::vector<double> values;  ///< from harmless to hopeless
  std::function<FailureCase(double value)> make;
  bool log = false;  ///< values are charted on a logarithmic axis
};

/// Each case is kFailureWidth x kFailureHeight DP pixels, of mean 0.25 and with the noise of 100 lux (811 electrons a
/// pixel) unless its row says otherwise. Textures have as much contrast in every octave ("1/f").
std::vector<FailureRow> failure_rows();
inline constexpr int kFailureWidth = 384, kFailureHeight = 192;

}  // namespace dualpixel::evaluation
