#pragma once
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "evaluation/chart/chart.h"

/// Settings of single stages, tried on one capture, or with one seed, after another.
namespace dualpixel::evaluation {

/// One setting, tried once; in the units of its section.
struct Trial {
  std::string name;
  double error = 0, time = 0;
  std::optional<double> memory_mb = {};
  bool is_default = false;
  bool is_bound = false;  ///< ChartPoint's
};

/// The RMS difference that a PSNR stands for, percent of white.
double percent_of_white(double psnr_db);

/// The defocus renderers and the baselines on the true all-in-focus picture, with true disparity and mask, against the
/// true photograph: RMS difference in sRGB, percent of white.
std::vector<Trial> try_defocus(const Capture& capture);

/// The person mask of a picture of the capture: with the face that the capture states and with the one that is found,
/// and filtered along edges. Error: 100 % less its IoU with the true mask at the picture's size. Without oneDNN, or
/// where the capture shows nobody: none.
std::vector<Trial> try_masks(const Capture& capture, const Image& picture);

/// The means over captures or seeds, each of which has the same settings; the memory of the first.
std::vector<ChartPoint> points_of(const std::vector<std::vector<Trial>>& repetitions);

}  // namespace dualpixel::evaluation
