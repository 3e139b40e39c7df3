#pragma once
#include <cmath>

#include "capture/names.h"

namespace dualpixel::simulator {

/// An ideal lens: perfect focus, no distortion; its pupil is where rays start and depth is counted from.
/// Closed forms: Wadhwa et al. 2018, supplement "Disparity To Depth Calculation", with the sign of capture/capture.h.
struct ThinLens {
  double focal_length_m = 0;
  double f_number = 0;
  double focus_distance_m = 0;  ///< z, from the pupil; infinity is allowed; greater than the focal length
  /// move: the lens moves away from the sensor and the picture grows as it focuses nearer ("breathing").
  /// power: the sensor stays where infinity has it, the focal length shortens, the picture keeps its size.
  enum class Focusing { move, power } focusing = Focusing::move;
  double pupil_magnification = 1;  ///< exit over entrance pupil; 1 for a thin lens, else the lens is thick

  double pupil_diameter_m() const { return focal_length_m / f_number; }
  /// Scale of the picture: sensor length per slope of the chief ray. A thin lens's distance from the sensor,
  /// 1/z_i = 1/f - 1/z; a thick one's with z counted from the entrance pupil.
  double image_distance_m() const {
    if (focusing == Focusing::power) return focal_length_m;
    return focal_length_m / (1 - focal_length_m / (pupil_magnification * focus_distance_m));
  }
  /// Signed blur diameter on the sensor of a point at planar depth D (infinity is allowed): negative in front of the
  /// focus plane. b = L z_i (1/z - 1/D), which is L f / (1 - f/z) (1/z - 1/D) for the thin lens that moves.
  double blur_diameter_m(double depth_m) const {
    return pupil_diameter_m() * image_distance_m() * (1 / focus_distance_m - 1 / depth_m);
  }
  /// Slope of the pupil's rim seen from the middle of the sensor: 1 / (2 working f-number).
  double rim_slope() const { return 0.5 * pupil_diameter_m() / image_distance_m(); }
  /// Illuminance on the sensor, in lux, per nit of scene radiance, on the axis: pi/4 (L/z_i)^2.
  double lux_per_nit() const { return M_PI * rim_slope() * rim_slope(); }
};

inline constexpr Named<ThinLens::Focusing> kFocusings[] = {
    {"move", ThinLens::Focusing::move, "the lens moves away from the sensor, the picture grows as it focuses nearer"},
    {"power", ThinLens::Focusing::power, "the focal length shortens, the picture keeps its size"},
};

}  // namespace dualpixel::simulator
