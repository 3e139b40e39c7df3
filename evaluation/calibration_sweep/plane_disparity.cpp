#include "evaluation/calibration_sweep/plane_disparity.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::evaluation {

Image plane_disparity(const simulator::DisparityField& field, const Camera& camera, double depth_m,
                      const pipeline::Correction* correction) {
  Image d(camera.dp_width() / 4, camera.dp_height() / 2), confidence(d.width, d.height, 1, 1.0f);
  for (int y = 0; y < d.height; ++y) {
    for (int x = 0; x < d.width; ++x) {
      const simulator::DisparityCoefficients c =
          field.at((x + 0.5) * camera.width_px / d.width, (y + 0.5) * camera.height_px / d.height);
      d.at(x, y) = static_cast<float>(c.slope_dp_px_m / depth_m + c.intercept_dp_px);
    }
  }
  if (correction) correct_disparity(*correction, d, confidence);
  return d;
}

double deviation_inside(const Image& map) {
  double sum = 0, squares = 0, count = 0;
  for (int y = map.height / 20; y < map.height - map.height / 20; ++y) {
    for (int x = map.width / 20; x < map.width - map.width / 20; ++x) {
      const double value = map.at(x, y);
      sum += value, squares += value * value, ++count;
    }
  }
  return std::sqrt(std::max(squares / count - sum / count * (sum / count), 0.0));
}

}  // namespace dualpixel::evaluation
