#pragma once
#include <string>

#include "pipeline/calibration/calibration.h"

/// Corrects disparity by a calibration: converts the disparity d measured at x to that which a point of the same depth
/// has at the principal point,
///     d_corrected = I_z(0) + S_z(0) (d - I_z(x)) / S_z(x)             (Wadhwa et al. 2018, section 4.2)
namespace dualpixel::pipeline {

/// S_z and I_z at a focus distance z, interpolated linearly in 1/z between the calibrated focus distances: both are
/// nearly linear in 1/z (the thin lens's intercept is -S/z), and 1/z is finite for a focus at infinity. Outside the
/// calibrated range: those of the nearest focus distance. So is the kernels' skew. Residual and r_squared stay empty.
FocusCalibration focus_at(const Calibration& calibration, double focus_distance_m);

/// The correction for one capture, ready to be applied to its maps.
struct Correction {
  /// At the nodes: d_corrected = gain d + offset. Nodes that are not usable hold the values of the nearest usable
  /// ones, so that interpolation beside them stays smooth.
  Image gain, offset_dp_px;
  SkewField skew;        ///< at that focus distance, for the matcher; may have no nodes
  Image usable;          ///< 0: no line, or its slope is under a fifth of the principal point's and mostly noise
  float confidence = 1;  ///< exp(-distance / 0.5 per meter) to the calibrated range of 1/z; 1 inside
  std::string warning;   ///< names both where the focus distance lies outside the range; else empty
};

/// Throws InputError where `camera` differs from `own` in name, size, pixel pitch, DP pixel, focal length, f-number or
/// principal point; `what` begins the message.
void require_same_camera(const Camera& own, const Camera& camera, const std::string& what);

/// Throws InputError where `camera` is not the calibration's, and where disparity at the principal point does not
/// change with depth at that focus distance.
Correction make_correction(const Calibration& calibration, const Camera& camera);

/// Of a part of the picture: from (x, y), `width` wide and `height` high, fractions of it.
Correction of_part(const Correction& whole, double x, double y, double width, double height);

/// In place, at any resolution of the same picture. Confidence is scaled by the correction's, and 0 where that is not
/// usable at one of the four nodes around; disparity is finite everywhere. `sigma_dp_px`, where there is one, is
/// scaled as the disparity is, and infinite where the correction is not usable.
void correct_disparity(const Correction& correction, Image& disparity_dp_px, Image& confidence,
                       Image* sigma_dp_px = nullptr);

}  // namespace dualpixel::pipeline
