#pragma once
#include <functional>
#include <optional>
#include <string>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/image/image.h"
#include "pipeline/portrait/options.h"
#include "pipeline/portrait/result.h"

/// The portrait mode of Wadhwa et al. 2018, "Synthetic Depth-of-Field with a Single-Camera Mobile Phone", stage by
/// stage: burst -> people -> disparity -> calibration -> mask merge -> edge-aware filtering -> blur -> noise.
namespace dualpixel::pipeline {

/// Nobody to keep sharp is found, in a picture that has no views either.
struct NobodyFound : InputError {
  using InputError::InputError;
};

/// Called with the name of the stage and the fraction of all stages that is done.
using PortraitProgress = std::function<void(const std::string& stage, double fraction)>;

/// Runs all stages on `capture`; its truth is never used. `person_mask` (one channel, 0..1, of any size: it is
/// stretched over the picture) serves the modes dp_seg and seg; without it, options.find_people makes one from the
/// merged picture, and where it finds no person the mode becomes dp, with a warning. Mode automatic chooses: dp_seg
/// where there are views and a person (a mask that is given, or what find_people finds), dp where there are views and
/// nobody, seg where there is a person and no view. A capture without mosaic gives a gray picture where none is given.
/// Mask and face that are given are those of the first frame; where the base is the second or third they are used as
/// they are, a hand's motion of a few pixels aside.
///
/// d_focus (section 5.1) is the median disparity over the largest face that is well focused; where there is none, over
/// the region tapped; without either the person's disparity in mode dp_seg, and 0 (trust the autofocus) in mode dp.
/// Faces are those given, the capture's, or those that find_people detects, bystanders' too where nobody is kept sharp.
/// Mode dp by its name doesn't ask for any, so that its results depend on no detector.
///
/// Throws InputError where an option is out of its range, where a given disparity does not fit, where a mode needs
/// views that the capture lacks, where a capture without views shows nobody (NobodyFound), where a mode has neither
/// mask nor find_people, or the mask is not one channel of finite values, where a given picture is not RGB of the
/// sensor's size in 0..1, where a face or the tap lies outside the picture, and where the calibration is another
/// camera's. Dense views (1 x 1) under a mosaic are matched by their green photosites (match_pixels.h).
PortraitResult run_portrait(const Capture& capture, const PortraitOptions& options = default_options(),
                            const std::optional<Image>& person_mask = {}, const PortraitProgress& progress = {});

}  // namespace dualpixel::pipeline
