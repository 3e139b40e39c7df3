#pragma once
#include <functional>
#include <string>
#include <vector>

#include "evaluation/methods/set_samples.h"

/// Pairs of views on which matching fails, each kind swept from harmless to hopeless.
namespace dualpixel::evaluation {

struct FailureRow {
  std::string name;  ///< key in the JSON
  std::string title;
  std::string sweep;           ///< the swept quantity, with unit
  std::string key;             ///< the same as a key, with unit
  std::vector<double> values;  ///< from harmless to hopeless
  /// The views at a value and their true disparity, NaN where it is left out. Another draw, from 0: other textures and
  /// other noise.
  std::function<ViewSample(double value, unsigned draw)> make;
  bool log = false;       ///< values are charted on a logarithmic axis
  std::string note = {};  ///< what is seen, and why no value breaks a method where none can
};

/// Views in closed form, or as the mean over points of the pupil of the view from each point, so that the truth is
/// exact: the centroid disparity of the visible surface, left out where a pixel sees more than one. No renderer, lens
/// or sensor has a part in them. Each is kIdealWidth x kIdealHeight DP pixels, of mean 0.25 and with the noise of
/// 100 lux (811 electrons a pixel) unless its row says otherwise. Textures have as much contrast in every octave
/// ("1/f").
std::vector<FailureRow> ideal_failure_rows();
inline constexpr int kIdealWidth = 384, kIdealHeight = 192;

}  // namespace dualpixel::evaluation
