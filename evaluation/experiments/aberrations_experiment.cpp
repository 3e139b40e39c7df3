#include "evaluation/experiments/aberrations_experiment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/calibration_sweep/plane_disparity.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kFieldWidth = 320;
constexpr double kPlaneOverFocus = 3;

}  // namespace

AberratedField measure_aberrated_field(const simulator::Simulation& simulation) {
  const Camera camera = describe_camera(simulation);
  AberratedField f;
  f.lens = simulation.lens.name;
  f.focus_distance_m = camera.focus_distance_m;
  f.plane_m = kPlaneOverFocus * f.focus_distance_m;
  const simulator::DisparityField field(prepare_lens(simulation));
  const int height = std::max(kFieldWidth * camera.height_px / camera.width_px, 1);
  f.before_dp_px = f.focus_m = f.light = f.left_share = Image(kFieldWidth, height);
  float brightest = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < kFieldWidth; ++x) {
      const simulator::DisparityCoefficients c =
          field.at((x + 0.5) * camera.width_px / kFieldWidth, (y + 0.5) * camera.height_px / height);
      const double light = c.left_light + c.right_light, in_focus_m = -c.slope_dp_px_m / c.intercept_dp_px;
      f.before_dp_px.at(x, y) = static_cast<float>(c.slope_dp_px_m / f.plane_m + c.intercept_dp_px);
      f.focus_m.at(x, y) = in_focus_m > 0 ? static_cast<float>(in_focus_m) : std::numeric_limits<float>::infinity();
      f.light.at(x, y) = static_cast<float>(light);
      f.left_share.at(x, y) = static_cast<float>(light > 0 ? c.left_light / light : 0.5);
      brightest = std::max(brightest, f.light.at(x, y));
    }
  }
  for (float& value : f.light.data) value /= brightest;

  const pipeline::Calibration calibration =
      pipeline::fit_calibration(camera, measure_around(simulation, f.focus_distance_m, {}));
  f.after_dp_px = f.before_dp_px;
  Image confidence(kFieldWidth, height, 1, 1.0f);
  correct_disparity(make_correction(calibration, camera), f.after_dp_px, confidence);
  f.before_sigma_dp_px = deviation_inside(f.before_dp_px);
  f.after_sigma_dp_px = deviation_inside(f.after_dp_px);
  return f;
}

nlohmann::ordered_json to_json(const std::vector<AberratedField>& fields) {
  const auto distance = [](double m) { return std::isfinite(m) ? nlohmann::ordered_json(m) : "inf"; };
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const AberratedField& f : fields) {
    const auto [darkest, brightest] = std::minmax_element(f.light.data.begin(), f.light.data.end());
    const auto [least, most] = std::minmax_element(f.left_share.data.begin(), f.left_share.data.end());
    const auto [near, far] = std::minmax_element(f.focus_m.data.begin(), f.focus_m.data.end());
    nlohmann::ordered_json remainders;
    for (const CalibrationRemainder& r : f.remainders) remainders[r.cause] = r.sigma_dp_px;
    rows.push_back({{"lens", f.lens},
                    {"focus_distance_m", distance(f.focus_distance_m)},
                    {"plane_m", distance(f.plane_m)},
                    {"before_sigma_dp_px", f.before_sigma_dp_px},
                    {"after_sigma_dp_px", f.after_sigma_dp_px},
                    {"remainder_sigma_dp_px", remainders},
                    {"least_light", *darkest / *brightest},
                    {"left_share", {*least, *most}},
                    {"focus_m", {distance(*near), distance(*far)}}});
  }
  return {{"format", "dualpixel-experiment-aberrations"}, {"version", 2}, {"cameras", rows}};
}

}  // namespace dualpixel::evaluation
