#include "evaluation/metrics/photograph_disparity.h"

#include <algorithm>

#include "simulator/lens/thin/thin_lens.h"

namespace dualpixel::evaluation {

Image photograph_disparity(const Capture& capture) {
  const Truth& truth = *capture.truth;
  const Camera& camera = capture.camera;
  const simulator::ThinLens ideal{1e-3 * camera.focal_length_mm, camera.f_number, camera.focus_distance_m};
  const bool known = camera.alpha > 0 && camera.f_number > 0 && ideal.focal_length_m > 0 &&
                     ideal.focus_distance_m > ideal.focal_length_m;
  if (truth.photograph_lens != "ideal" || !known) return truth.disparity_dp_px;
  const double disparity_over_blur = camera.alpha / (1e-6 * camera.dp_pitch_um());  // DP pixels of a meter
  Image disparity(truth.depth_m.width, truth.depth_m.height);
  std::transform(truth.depth_m.data.begin(), truth.depth_m.data.end(), disparity.data.begin(), [&](float depth_m) {
    return static_cast<float>(disparity_over_blur * ideal.blur_diameter_m(depth_m));
  });
  return disparity;
}

}  // namespace dualpixel::evaluation
