#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/image/display.h"
#include "capture/image/image.h"
#include "pipeline/calibration/calibration.h"
#include "pipeline/defocus/blur_radius.h"
#include "pipeline/defocus/methods.h"
#include "pipeline/defocus/noise.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/upsample.h"
#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/edge_aware/smooth_disparity.h"
#include "pipeline/segmentation/merge_mask.h"
#include "pipeline/segmentation/person_mask.h"

/// The portrait mode of Wadhwa et al. 2018, "Synthetic Depth-of-Field with a Single-Camera Mobile Phone", stage by
/// stage: burst -> people -> disparity -> calibration -> mask merge -> edge-aware filtering -> blur -> noise.
namespace dualpixel::pipeline {

enum class Mode {
  dp,      ///< disparity alone
  dp_seg,  ///< disparity flattened inside the person mask (paper section 4.3)
  seg      ///< person mask alone: a background blur, two layers
};

/// Each stage's header says what its values mean and where they are from.
struct PortraitOptions {
  Mode mode = Mode::dp;
  std::string matcher = "paper";  ///< a name of the table in matchers.h
  std::uint64_t seed = 1;         ///< of the synthetic noise
  /// A face counts as well focused, and its median disparity as d_focus, up to this |disparity| in DP px. The paper
  /// asks for "close to zero" (section 5.1) and gives no value.
  double face_in_focus_dp_px = 0.5;
  MatcherOptions matching;  ///< noise is the capture's own, estimated where that has none
  UpsampleOptions tile_upsample;
  std::optional<Calibration> calibration;  ///< of the capture's camera; matched disparity is corrected by it
  /// Of people, full-resolution px, largest first; empty: Capture::face_px, or else those that find_people detects.
  std::vector<Face> faces;
  std::optional<Face> tap;  ///< a region that the user pointed at, full-resolution px
  /// Finds the people of a linear RGB picture where a mode needs a mask and none is given; usually
  /// pipeline::find_people. Nobody is found where it has no faces, or anybody_seen() denies it.
  std::function<FoundPeople(const Image& linear_rgb)> find_people;
  /// The finished picture of a camera that gives no mosaic, as PortraitResult::input; in place of the
  /// burst's, which must have one frame.
  std::optional<Image> picture;
  MergeMaskOptions merge_mask;
  SmoothOptions smooth;
  FilterMaskOptions filter_mask;
  BlurRadiusOptions blur_radius;
  /// Set: the blur of a lens with this entrance pupil in place of Eq. 5's (match_lens.h); not in mode seg.
  std::optional<double> match_pupil_mm;
  /// The bokeh's white level is the capture's own; mask_blur's radius is blur_for_face's where a face is known.
  DefocusOptions defocus;
  NoiseOptions noise;
  bool synthetic_noise = true;  ///< on what the blur has smoothed
  DisplayOptions display;
};

struct StageTime {
  std::string name;  ///< "merge", "disparity", "smooth", "blur", ... also the key in result.json
  double ms = 0;
  double peak_rss_mb = 0;  ///< of the process, after the stage
};

/// Everything at the full sensor's size unless said. Linear images are in the capture's normalised signal after white
/// balance, clipped where the first colour clips.
struct PortraitResult {
  Mode mode = Mode::dp;           ///< as asked for; dp where that needed people and none were found
  Image input;                    ///< linear RGB, merged burst, demosaicked, or as given: the picture before blurring
  Image portrait;                 ///< linear RGB with synthetic defocus and noise
  Image portrait_srgb;            ///< the same, exposed and gamma-encoded for display, 0..1
  Image disparity_dp_px;          ///< smoothed, DP pixels; empty in mode seg
  Image confidence;               ///< of the matches that it was smoothed from, 0..1; empty in mode seg
  Image matched_disparity_dp_px;  ///< corrected but not smoothed, at DP resolution (dp_width x dp_height); empty in
                                  ///< mode seg
  Image matched_confidence;
  Image matched_sigma_dp_px;  ///< of matched_disparity_dp_px, as predicted: by the likelihood matcher alone
  Image mask;  ///< person mask, 0..1: edge-aware filtered in mode seg, as given or found in dp_seg, empty in dp
  std::vector<Face> faces;  ///< that seeded a mask that was found, full-resolution pixels, largest first
  Image blur_radius_px;     ///< r(x) of Eq. 5, full-resolution pixels
  double focus_disparity_dp_px = 0;
  int base_frame = 0;  ///< of the burst: whose scene and pose the pictures and maps show
  std::vector<StageTime> stages;
  std::vector<std::string> warnings;  ///< for people: what makes the result less good than it could be
};

/// Called with what is being done and the fraction of all stages that is.
using PortraitProgress = std::function<void(const std::string& stage, double fraction)>;

/// Runs all stages on `capture`; its truth is never looked at. `person_mask` (one channel, 0..1, of any size: it is
/// stretched over the picture) serves the modes dp_seg and seg; without it, options.find_people makes one from the
/// merged picture, and where it finds nobody the mode becomes dp, with a warning. A capture without mosaic gives a grey
/// picture where none is given. Mask and face that are given are those of the first frame; where the base is the second
/// or third they are used as they are, a hand's motion of a few pixels aside.
///
/// d_focus (section 5.1) is the median disparity over the largest face that is well focused; where there is none, over
/// the region tapped; without either the person's disparity in mode dp_seg, and 0 (trust the autofocus) in mode dp,
/// which looks for no faces of its own.
///
/// Throws InputError where a mode has neither mask nor find_people, or the mask is not one channel of finite values,
/// where a given picture is not RGB of the sensor's size in 0..1, and where the calibration is another camera's. Dense
/// views (1 x 1) must be of one colour: half-photosites under a mosaic hold nothing that could be matched.
PortraitResult run_portrait(const Capture& capture, const PortraitOptions& options = {},
                            const std::optional<Image>& person_mask = {}, const PortraitProgress& progress = {});

}  // namespace dualpixel::pipeline
