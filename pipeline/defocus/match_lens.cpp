#include "pipeline/defocus/match_lens.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

#include "capture/error.h"

namespace dualpixel::pipeline {

BlurMapping match_lens(const Camera& camera, double pupil_mm, double focus_dp_px, bool input_is_sharp) {
  if (!(camera.alpha > 0)) {
    throw InputError("capture: /camera/alpha: unknown: matching a lens needs disparity over blur diameter, above 0");
  }
  if (!(camera.focal_length_mm > 0 && camera.f_number > 0)) {
    throw InputError("capture: /camera/focal_length_mm, f_number: unknown: matching a lens needs both, above 0");
  }
  const double wider = pupil_mm * camera.f_number / camera.focal_length_mm;
  const double discs = input_is_sharp ? wider : std::sqrt(std::max(wider * wider - 1, 0.0));
  BlurMapping mapping;
  mapping.kappa = discs * camera.dp_downsample_x / (2 * camera.alpha);
  mapping.focus_dp_px = focus_dp_px;
  mapping.r_max_px = camera.width_px / 8.0;
  return mapping;
}

double pupil_mm_of_lens(const std::string& field, const std::string& lens) {
  const char *at = lens.data(), *const end = at + lens.size();
  const auto skip = [&](std::string_view text) {
    const bool found = std::string_view(at, end).starts_with(text);
    if (found) at += text.size();
    return found;
  };
  const auto read = [&](double& value) {
    const auto [stop, error] = std::from_chars(at, end, value);
    at = stop;
    return error == std::errc();
  };
  double f_number = 0, focal_length_mm = 0;
  const bool whole =
      skip("f/") && read(f_number) && skip("@") && read(focal_length_mm) && skip("mm-equivalent") && at == end;
  if (!whole || !(f_number >= 0.5 && f_number <= 64) || !(focal_length_mm >= 1 && focal_length_mm <= 2000)) {
    throw InputError(field + " " + printable(lens) +
                     ": must read like f/1.4@50mm-equivalent, f-number 0.5 to 64, focal length 1 to 2000 mm");
  }
  return focal_length_mm / f_number;
}

}  // namespace dualpixel::pipeline
