#pragma once
#include <string>
#include <vector>

#include "capture/capture.h"
#include "pipeline/disparity/noise_model.h"

namespace dualpixel::evaluation {

/// A pair of views whose disparity is known, all of one size.
struct ViewSample {
  std::string name;
  Image left, right;  ///< normalized signal, with the sensor's noise
  Image truth_dp_px;  ///< NaN where it is not known
  pipeline::ViewSensor sensor;
};

/// The folders of a set's samples, in the order of their names: of a data set (docs/dataset.md) those that are
/// rendered, of the split where one is named; of any other folder the captures in it, which are of no split. Throws
/// InputError where there are none.
std::vector<std::string> sample_folders(const std::string& set, const std::string& split);

/// A sample whose recipe keeps left, right, view_disparity_dp_px and view_valid (in the layouts exr and npy), or a
/// capture with truth, whose disparity at a view's pixel is that of the photosite below and to the right of its center.
/// Of dense captures the sample is what a sensor with DP pixels of 2 x 2 photosites would have read, as the portrait
/// matches them (pipeline/disparity/match_pixels.h), disparity in its DP pixels. Throws InputError.
ViewSample read_view_sample(const std::string& folder);

/// The same of a capture with truth, whose views are given: those of its first frame, or merged ones that show it.
ViewSample view_sample(const Capture& capture, Image left, Image right, const pipeline::ViewSensor& sensor);

}  // namespace dualpixel::evaluation
