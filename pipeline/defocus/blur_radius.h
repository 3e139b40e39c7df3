#pragma once
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// From disparity to blur radius (Wadhwa et al. 2018, section 5.1 and supplement, "Blur Parameters"). The supplement's
/// signs are turned: here frontal means d - d_focus < 0.
namespace dualpixel::pipeline {

struct BlurRadiusOptions {
  /// s: full-resolution px of radius for one DP px of disparity, in a picture `reference_width_px` wide; it grows in
  /// proportion to the width. The paper gives no value. A lens whose pupil is k times as wide blurs by a radius of
  /// k / alpha px (2 photosites a DP pixel): 24 is a pupil five times as wide with alpha = 0.21.
  double scale_px_per_dp_px = 24;
  double reference_width_px = 2688;
  double r_max_px = 30;           ///< largest radius, full-resolution px (section 5.1)
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
/// kappa_2(d_focus) = clamp(1 / (1 - d_focus / 2), 0.5, 2): 2 as well where the denominator is 0 or less.
double kappa_2(double focus_dp_px);

/// `person` says that a mask has flattened the subject's disparities.
BlurMapping make_blur_mapping(double focus_distance_m, double focus_dp_px, int image_width_px, bool person,
                              const BlurRadiusOptions& options = {});

/// r(x), full-resolution px.
Image blur_radii(const Image& disparity_dp_px, const BlurMapping& mapping);

}  // namespace dualpixel::pipeline
