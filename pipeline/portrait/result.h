#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/portrait/options.h"
#include "pipeline/segmentation/faces.h"

namespace dualpixel::pipeline {

struct StageTime {
  std::string name;  ///< "merge", "disparity", "smooth", "blur", ... also the key in result.json
  double ms = 0;
  double peak_rss_mb = 0;  ///< of the process, after the stage
};

/// Everything at the full sensor's size unless said. Linear images are in the capture's normalized signal after white
/// balance, clipped where the first color clips.
struct PortraitResult {
  Mode mode = Mode::dp;     ///< never automatic: as asked for; dp where that needed people and none were found
  std::string mode_reason;  ///< why Mode::automatic chose it; empty where it was asked for
  /// x, y, width, height: the part of the picture that PortraitOptions::zoom left
  std::optional<std::array<int, 4>> window_px;
  Image input;                    ///< linear RGB, merged burst, demosaicked, or as given: the picture before blurring
  Image portrait;                 ///< linear RGB with synthetic defocus and noise
  Image portrait_srgb;            ///< the same, exposed and gamma-encoded for display, 0..1
  Image disparity_dp_px;          ///< smoothed, DP pixels; empty in mode seg
  Image confidence;               ///< of the matches that it was smoothed from, 0..1; empty in mode seg
  Image matched_disparity_dp_px;  ///< corrected but not smoothed, at DP resolution (dp_width x dp_height); empty in
                                  ///< mode seg
  Image matched_confidence;
  Image matched_sigma_dp_px;  ///< of matched_disparity_dp_px, as predicted; empty where the matcher predicts none
  Image mask;  ///< person mask, 0..1: edge-aware filtered in mode seg, as given or found in dp_seg, empty in dp
  std::vector<Face> faces;  ///< that seeded a mask that was found, pixels of the whole picture, largest first
  Image blur_radius_px;     ///< r(x) of Eq. 5, full-resolution pixels
  double focus_disparity_dp_px = 0;
  int base_frame = 0;  ///< of the burst: whose scene and pose the pictures and maps show
  std::vector<StageTime> stages;
  std::vector<std::string> warnings;  ///< for people: what makes the result less good than it could be
};

}  // namespace dualpixel::pipeline
