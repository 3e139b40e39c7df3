#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/image/display.h"
#include "capture/image/image.h"
#include "capture/names.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/calibration.h"
#include "pipeline/defocus/blur_radius.h"
#include "pipeline/defocus/noise.h"
#include "pipeline/defocus/options.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/upsample.h"
#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/edge_aware/smooth_disparity.h"
#include "pipeline/option_field.h"
#include "pipeline/portrait/given_disparity.h"
#include "pipeline/segmentation/merge_mask.h"
#include "pipeline/segmentation/person_mask.h"

namespace dualpixel::pipeline {

enum class Mode { automatic, dp, dp_seg, seg };

inline constexpr Named<Mode> kModes[] = {
    {"auto", Mode::automatic, "views and people: dp+seg; views without people: dp; people without views: seg"},
    {"dp", Mode::dp, "disparity alone"},
    {"dp+seg", Mode::dp_seg, "disparity flattened inside the person mask (section 4.3)"},
    {"seg", Mode::seg, "person mask alone: a blurred background behind a sharp person"},
};

/// Each stage's header defines its options and their sources. PortraitOptions() is the paper's method throughout, and
/// smooths a disparity that is given; default_options() is what people get.
struct PortraitOptions {
  Mode mode = Mode::dp;
  std::string matcher = "paper";  ///< a name of the table in matchers.h
  std::uint64_t seed = 1;         ///< of the synthetic noise

  // About the picture. Faces, tap and a given mask are those of the upright picture.

  /// Of people, full-resolution px. Empty, and without a tap: Capture::face_px, or else those that find_people detects.
  std::vector<Face> faces;
  std::optional<Face> tap;  ///< the region that the user pointed at, full-resolution px; tapped_region() makes one
  /// The capture's pictures lie on their side, transposed, as those of a vertically split pair do (plain_pair.h).
  /// Faces, tap, mask and the whole result are upright all the same.
  bool transposed = false;
  /// The finished picture of a camera that gives no mosaic, linear RGB, as PortraitResult::input; in place of the
  /// burst's, which must have one frame.
  std::optional<Image> picture;
  std::optional<GivenDisparity> disparity;  ///< in place of a matcher's; not in mode seg
  std::optional<Calibration> calibration;   ///< of the capture's camera; disparity is corrected by it
  /// The middle of the picture alone, as by a sensor 1.5 times as small on either side (zoom.h). Faces, tap, mask and
  /// disparity that are given are those of the whole picture.
  bool zoom = false;
  /// Finds the people of an upright linear RGB picture where a mode needs a mask and none is given; usually
  /// pipeline::find_people. `seeds` are the faces given; empty: detect them. Mode automatic without it finds nobody.
  std::function<FoundPeople(const Image& linear_rgb, const std::vector<Face>& seeds)> find_people;

  // The stages, in their order.

  MergeOptions merge;
  SeedOptions seed_faces;  ///< for find_people
  MatcherOptions matching;
  UpsampleOptions tile_upsample;
  MergeMaskOptions merge_mask;
  SmoothOptions smooth;
  FilterMaskOptions filter_mask;
  /// A face counts as well focused, and its median disparity as d_focus, up to this |disparity| in DP px of a picture
  /// as wide as blur_radius's reference. The paper asks for "close to zero" (section 5.1) and gives no value.
  double face_in_focus_dp_px = 0.5;
  BlurRadiusOptions blur_radius;
  /// Set: the blur of a lens with this entrance pupil in place of Eq. 5's (match_lens.h); not in mode seg.
  std::optional<double> match_pupil_mm;
  /// The bokeh's white level is the capture's own; mask_blur's radius is blur_for_face's where a face is known.
  DefocusOptions defocus;
  NoiseOptions noise;
  bool synthetic_noise = true;  ///< on what the blur has smoothed
  DisplayOptions display;
};

/// The defaults for one matcher, by its name in matchers.h: options that name it, and smoothing that suits it. Where
/// its windows are wide, smoothing is robust (BilateralSolverOptions): on each side of an edge most answers outvote
/// those from across. Throws InputError for a name that the table lacks.
PortraitOptions default_options(std::string_view matcher = kDefaultMatcher);

/// Every number that a stage takes, by the name that `portrait --set` knows: "match.range_px", "layers.bands", ...
/// What has an option of its own on the command line (mode, matcher, seed, aperture, ...) is not among them.
OptionFields fields(PortraitOptions& options);

/// Throws InputError, with field, value and what is allowed, where a stage's option is out of its range.
void check(const PortraitOptions& options);

/// The fields that differ from the defaults for their matcher, {name: value}; for a result's provenance.
nlohmann::ordered_json changed_fields(const PortraitOptions& options);

/// A table of all fields for people: name, default for this matcher, range, unit and source.
std::string describe_fields(std::string_view matcher);

}  // namespace dualpixel::pipeline
