#include "pipeline/defocus/match_lens.h"

#include <algorithm>
#include <cmath>

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

}  // namespace dualpixel::pipeline
