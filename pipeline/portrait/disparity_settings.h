#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/capture.h"
#include "pipeline/portrait/options.h"

/// Speed against accuracy of disparity, for `portrait --auto`: matchers and smoothing that are worth choosing.
namespace dualpixel::pipeline {

/// One of the settings that `dualpixel chart` measures ("Disparity by --auto"), on the machine and scenes that
/// docs/disparity.md names. Figures are of that chart: another machine takes another time, other scenes other errors.
struct DisparitySetting {
  std::string_view name;
  /// CPU time, all threads together: of matching what does not depend on the size, and what does, over the megapixels
  /// of a view as it is matched; of smoothing and upsampling, over those of the picture.
  double fixed_ms = 0, matching_ms = 0, smoothing_ms = 0;
  /// Promised: root mean square of the disparity's error over the scenes, without a fit, DP px; 1 to 3 % above what was
  /// measured.
  double error_dp_px = 0;
  std::string_view matcher;
  std::vector<std::string_view> assignments;  ///< what else differs from the matcher's defaults, as --set has it
};

/// Fastest first, for a phone's DP pixels of 2 x 4 photosites; each errs by less than all before it. The last has the
/// defaults.
std::span<const DisparitySetting> disparity_settings();

struct Megapixels {
  double picture = 0, view = 0;  ///< `view`: as it is matched
};
Megapixels megapixels_of(const Capture& capture);

double cpu_ms(const DisparitySetting& setting, const Megapixels& size);

/// The setting of least error that takes at most so long. Throws InputError that begins with "--auto", where none does.
const DisparitySetting& best_setting(double most_cpu_ms, const Megapixels& size);

/// The fastest setting that errs by at most `error_dp_px`. Throws InputError that begins with "--auto-error", where
/// none errs by so little.
const DisparitySetting& fastest_setting(double error_dp_px);

/// The options with the setting's matcher and smoothing in place of their own.
PortraitOptions with_setting(PortraitOptions options, const DisparitySetting& setting);

/// Throws InputError where `assignment` ("smooth.divisor=8") is of smoothing, which settings choose.
void require_not_chosen(std::string_view assignment);

/// The command line's options that do the same: "--matcher likelihood --set smooth.divisor=8".
std::string command_line(const DisparitySetting& setting);

}  // namespace dualpixel::pipeline
