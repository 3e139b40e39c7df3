#include "evaluation/metrics/photograph_disparity.h"

namespace dualpixel::evaluation {

Image photograph_disparity(const Capture& capture) {
  const Truth& truth = *capture.truth;
  const Camera& camera = capture.camera;
  const double focal_m = 1e-3 * camera.focal_length_mm, focus_m = camera.focus_distance_m;
  const bool known = camera.alpha > 0 && camera.f_number > 0 && focal_m > 0 && focus_m > focal_m;
  if (truth.photograph_lens != "ideal" || !known) return truth.disparity_dp_px;
  const double pupil_m = focal_m / camera.f_number, pitch_m = 1e-6 * camera.dp_pitch_um();
  const double scale = camera.alpha * pupil_m * focal_m / (1 - focal_m / focus_m) / pitch_m;
  Image disparity(truth.depth_m.width, truth.depth_m.height);
  for (std::size_t i = 0; i < disparity.data.size(); ++i) {
    disparity.data[i] = static_cast<float>(scale * (1 / focus_m - 1 / truth.depth_m.data[i]));
  }
  return disparity;
}

}  // namespace dualpixel::evaluation
