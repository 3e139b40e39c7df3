#pragma once
#include <string>
#include <vector>

#include "capture/capture.h"
#include "evaluation/chart/chart.h"

/// Settings of single stages of the pipeline, tried on one capture after another.
namespace dualpixel::evaluation {

/// One setting on one capture.
struct Trial {
  std::string name;
  double error = 0, cpu_ms = 0;
  double memory_mb = 0;
  bool is_default = false;
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

/// The means over captures, each of which has the same settings; the memory of the first.
std::vector<ChartPoint> points_of(const std::vector<std::vector<Trial>>& by_capture);

}  // namespace dualpixel::evaluation
