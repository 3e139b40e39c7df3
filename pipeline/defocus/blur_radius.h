#pragma once
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// From disparity to blur radius (Wadhwa et al. 2018, section 5.1 and supplement, "Blur Parameters"). The supplement's
/// signs are turned: here frontal means d - d_focus < 0.
namespace dualpixel::pipeline {

/// The paper's constants are those of its pictures, 2688 px wide with DP pixels two px wide. A picture of another size
/// or with other DP pixels is blurred as if it had been scaled to that: disparities count in DP pixels of 2 / 2688 of
/// the width, radii in px of 1 / 2688. So how strong a blur looks doesn't depend on the number of pixels.
struct BlurRadiusOptions {
  /// s: px of radius for one DP px of disparity. The paper gives no value. A lens whose pupil is k times as wide blurs
  /// by a radius of k / alpha px: 24 is a pupil five times as wide with alpha = 0.21.
  double scale_px_per_dp_px = 24;
  double reference_width_px = 2688;
  double r_max_px = 30;           ///< largest radius (section 5.1)
  double frontal_factor = 0.6;    ///< on kappa in front of the focus (supplement)
  double sharp_px = 0.56;         ///< d_0 = sharp_px / kappa stays sharp on either side (supplement)
  double sharp_person_px = 0.19;  ///< the same where a mask has flattened a person (supplement)
};

OptionFields fields(BlurRadiusOptions& options);

/// Eq. 5: r(d) = kappa max(0, |d - d_focus| - d_0), at most r_max, with kappa times frontal_factor where d < d_focus.
struct BlurMapping {
  double kappa = 0;        ///< full-resolution px for one DP px
  double focus_dp_px = 0;  ///< d_focus
  double sharp_dp_px = 0;  ///< d_0
  double frontal_factor = 1;
  double r_max_px = 0;

  /// 0 where the disparity is not a number, and everywhere where kappa is 0.
  float radius_px(float disparity_dp_px) const;
  /// The disparities in front of and behind the focus at which r(d), were it not capped, is `radius_px` > 0.
  double front_dp_px(double radius_px) const;
  double back_dp_px(double radius_px) const;
};

/// kappa_1(z) = clamp(0.33 z + 0.17, 1, 3.5), z in meters, may be infinite (supplement).
double kappa_1(double focus_distance_m);
/// kappa_2(d_focus) = clamp(1 / (1 - d_focus / 2), 0.5, 2). Past the pole, where the denominator is 0 or less, the
/// formula would turn negative and clamp to 0.5: blur would fall to a quarter where the focus moves by a hair. Ours
/// departs from it there and stays at 2, which it has from d_focus = 1 on.
double kappa_2(double focus_dp_px);

/// DP pixels of the reference for one of a picture `image_width_px` wide whose DP pixels are `px_per_dp_px` px wide.
double reference_dp_px(int image_width_px, double px_per_dp_px, const BlurRadiusOptions& options = {});

/// In the picture's own units. `person` says that a mask has flattened the subject's disparities.
BlurMapping make_blur_mapping(double focus_distance_m, double focus_dp_px, int image_width_px, bool person,
                              const BlurRadiusOptions& options = {}, double px_per_dp_px = 2);

/// r(x), full-resolution px.
Image blur_radii(const Image& disparity_dp_px, const BlurMapping& mapping);

}  // namespace dualpixel::pipeline
