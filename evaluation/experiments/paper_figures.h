#pragma once
#include <functional>
#include <optional>
#include <string>

#include "capture/capture.h"
#include "pipeline/calibration/calibration.h"

/// The figures of Wadhwa et al. 2018 that compare a step of the pipeline with its absence, made of one capture.
namespace dualpixel::evaluation {

struct PaperFigures {
  Capture capture;
  std::string matcher = "paper";                     ///< a name in pipeline/disparity/matchers.h
  std::optional<pipeline::Calibration> calibration;  ///< of the capture's camera, for Fig. 8
};

/// A page of: Fig. 7, disparity and portrait of one frame and of the burst (where it has several); Fig. 8, without and
/// with calibration (where one is given); Fig. 11, the sharp range around the focus and the physical mapping; Fig. 13,
/// the ideal disc, the one that is scattered and its derivative; Fig. 14, without and with synthetic noise; Fig. 16b,
/// modes dp and dp+seg (where several people are found); Fig. S2, the views' traces before and after normalization. All
/// others in mode dp. Throws InputError as run_portrait() does.
std::string paper_figures_page(const PaperFigures& figures, const std::function<void(double fraction)>& progress = {});

}  // namespace dualpixel::evaluation
