#pragma once
#include <cmath>

namespace dualpixel::simulator {

/// An ideal thin lens that focuses by moving: the pupil is the lens, the sensor stands at image_distance_m behind it.
/// Closed forms: Wadhwa et al. 2018, supplement "Disparity To Depth Calculation", with the sign of capture/capture.h.
struct ThinLens {
  double focal_length_m = 0;
  double f_number = 0;
  double focus_distance_m = 0;  ///< z, from the lens; infinity is allowed; greater than the focal length

  double pupil_diameter_m() const { return focal_length_m / f_number; }
  /// 1/z_i = 1/f - 1/z.
  double image_distance_m() const { return focal_length_m / (1 - focal_length_m / focus_distance_m); }
  /// Signed blur diameter on the sensor of a point at planar depth D (infinity is allowed): negative in front of the
  /// focus plane. b = L f / (1 - f/z) * (1/z - 1/D).
  double blur_diameter_m(double depth_m) const {
    return pupil_diameter_m() * image_distance_m() * (1 / focus_distance_m - 1 / depth_m);
  }
  /// Illuminance on the sensor, in lux, per nit of scene radiance, on the axis: pi/4 (L/z_i)^2. The fall-off towards
  /// the corner (cos^4) is left out: the thin lens is the model of a lens whose shading has been corrected.
  double lux_per_nit() const {
    const double working_aperture = pupil_diameter_m() / image_distance_m();
    return 0.25 * M_PI * working_aperture * working_aperture;
  }
};

}  // namespace dualpixel::simulator
