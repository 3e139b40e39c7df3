#pragma once
#include <array>
#include <vector>

#include "simulator/lens/field_map.h"

namespace dualpixel::simulator {

/// Independent knobs on an ideal lens, each with a closed form (lens_models/README.md). All zero, it is the thin lens.
/// The ray that meets the sensor at X after crossing the pupil at p (in radii; p_t along X, p_s across it) is the ideal
/// lens's ray for X / (1 + distortion) - delta, where delta(X, p) is the sum of the transverse aberrations below.
/// R is the pupil radius, z_i the image distance, h = |X| / image_radius.
struct Aberrations {
  double image_radius_mm = 3.528;

  double focus_um = 0;                 ///< focus surface minus sensor on the axis, + behind: delta = -R p dz / z_i
  EvenPolynomial tangential_focus_um;  ///< ... and over the field, for p along X
  EvenPolynomial sagittal_focus_um;    ///< ... for p across X
  std::vector<double> spherical_um;    ///< c3, c5, ...: delta = (c3 rho^3 + c5 rho^5 + ...) p / rho, rho = |p|
  EvenPolynomial distortion;           ///< (|X| - ideal) / ideal
  std::array<double, 2> longitudinal_color_um{};  ///< focus of R and of B minus that of G
  std::array<double, 2> lateral_color{};          ///< picture size of R and of B over that of G, minus 1
  EvenPolynomial tangential_pupil;                ///< growth of the entrance pupil over the field, along X ...
  EvenPolynomial sagittal_pupil;                  ///< ... and across it

  /// A round rim elsewhere in the lens, seen in the pupil: light passes where |p - shift h X/|X|| <= radius. Two discs
  /// make the cat's eye.
  struct Rim {
    double radius = 1;  ///< in pupil radii
    double shift = 0;   ///< at h = 1, in pupil radii
  };
  std::vector<Rim> rims;

  /// cos4: of the chief ray; disc: of each ray, which adds up to the exact law of the disc (physics of a flat pupil).
  enum class Falloff { none, cos4, disc } falloff = Falloff::none;
  FieldMap split_offset;                 ///< where the halves meet, in pupil radii: + gives the left view more light
  FieldMap left_gain{1}, right_gain{1};  ///< lens shading of each view, 0 ... 1
};

}  // namespace dualpixel::simulator
