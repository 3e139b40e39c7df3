#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/portrait/options.h"

/// Speed against accuracy of disparity, for `portrait --auto`: matcher, solver and upsampling that are worth choosing.
namespace dualpixel::pipeline {

/// One point of the front that `dualpixel chart` measures ("Disparity by --auto"), on the machine and scenes that
/// docs/disparity.md names. Figures are of that chart: another machine takes another time, other scenes other errors.
struct DisparitySetting {
  std::string_view name;
  /// CPU time of matching, smoothing and upsampling, all threads together, over the picture's megapixels.
  double cpu_ms_per_megapixel = 0;
  /// Root mean square of the disparity's error, without a fit, at the views' resolution, DP px.
  double error_dp_px = 0;
  std::string_view matcher;
  std::vector<std::string_view> assignments;  ///< what else differs from the matcher's defaults, as --set has it
};

/// Fastest first; each errs by less than all before it.
std::span<const DisparitySetting> disparity_settings();

/// The setting of least error that takes at most `cpu_ms` for a picture of so many megapixels. Throws InputError that
/// begins with "--auto", where even the fastest takes longer.
const DisparitySetting& best_setting(double cpu_ms, double megapixels);

/// The fastest setting that errs by at most `error_dp_px`. Throws InputError that begins with "--auto-error", where
/// none errs by so little.
const DisparitySetting& fastest_setting(double error_dp_px);

/// The options of the portrait with the setting's matching, upsampling and smoothing in place of their own.
PortraitOptions with_setting(PortraitOptions options, const DisparitySetting& setting);

/// Throws InputError where `field` ("smooth.divisor") is among what settings choose.
void require_not_chosen(std::string_view field);

/// The command line's options that do the same: "--matcher likelihood --set smooth.divisor=8".
std::string command_line(const DisparitySetting& setting);

}  // namespace dualpixel::pipeline
