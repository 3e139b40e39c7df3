#include "pipeline/defocus/blur_radius.h"

#include <algorithm>
#include <cmath>

#include "capture/image/rows.h"

namespace dualpixel::pipeline {

double kappa_1(double focus_distance_m) { return std::clamp(0.33 * focus_distance_m + 0.17, 1.0, 3.5); }

double kappa_2(double focus_dp_px) {
  const double denominator = 1 - focus_dp_px / 2;
  return denominator > 0 ? std::clamp(1 / denominator, 0.5, 2.0) : 2.0;
}

OptionFields fields(BlurRadiusOptions& options) {
  return {{"scale_px_per_dp_px", &options.scale_px_per_dp_px, 0, 1e6, "px a DP px", "ours"},
          {"reference_width_px", &options.reference_width_px, 1, 1e6, "px", "ours"},
          {"r_max_px", &options.r_max_px, 0, 1000, "px of 2688", "5.1: 30"},
          {"frontal_factor", &options.frontal_factor, 0, 100, "", "S: 0.6"},
          {"sharp_px", &options.sharp_px, 0, 1000, "px of 2688", "S: 0.56"},
          {"sharp_person_px", &options.sharp_person_px, 0, 1000, "px of 2688", "S: 0.19"}};
}

float BlurMapping::radius_px(float disparity_dp_px) const {
  const double offset = disparity_dp_px - focus_dp_px;
  const double strength = offset < 0 ? kappa * frontal_factor : kappa;
  // 0 first: std::max returns it where the other is not a number
  return static_cast<float>(std::min(strength * std::max(0.0, std::abs(offset) - sharp_dp_px), r_max_px));
}

double BlurMapping::front_dp_px(double radius_px) const {
  return focus_dp_px - sharp_dp_px - radius_px / (kappa * frontal_factor);
}

double BlurMapping::back_dp_px(double radius_px) const { return focus_dp_px + sharp_dp_px + radius_px / kappa; }

double reference_dp_px(int image_width_px, double px_per_dp_px, const BlurRadiusOptions& options) {
  return px_per_dp_px / 2 * options.reference_width_px / image_width_px;
}

BlurMapping make_blur_mapping(double focus_distance_m, double focus_dp_px, int image_width_px, bool person,
                              const BlurRadiusOptions& options, double px_per_dp_px) {
  BlurMapping mapping;
  const double own_px = image_width_px / options.reference_width_px;  // for one of the reference
  const double focus = focus_dp_px * reference_dp_px(image_width_px, px_per_dp_px, options);
  mapping.kappa = options.scale_px_per_dp_px * (px_per_dp_px / 2) * kappa_1(focus_distance_m) * kappa_2(focus);
  mapping.focus_dp_px = focus_dp_px;
  mapping.sharp_dp_px = own_px * (person ? options.sharp_person_px : options.sharp_px) / mapping.kappa;
  mapping.frontal_factor = options.frontal_factor;
  mapping.r_max_px = own_px * options.r_max_px;
  return mapping;
}

Image blur_radii(const Image& disparity_dp_px, const BlurMapping& mapping) {
  Image radii(disparity_dp_px.width, disparity_dp_px.height);
  for_rows(radii.height, [&](int y) {
    for (int x = 0; x < radii.width; ++x) radii.row(y)[x] = mapping.radius_px(disparity_dp_px.row(y)[x]);
  });
  return radii;
}

}  // namespace dualpixel::pipeline
