#pragma once
#include <array>
#include <string>
#include <vector>

#include "simulator/lens/aberrated/field_map.h"
#include "simulator/lens/thin/thin_model.h"

namespace dualpixel::simulator {

/// Where h = 1 lies on the sensor of a focused lens, for an image circle of the picture of infinity.
inline double field_radius_m(double image_radius_mm, const ThinLens& thin) {
  return image_radius_mm * 1e-3 * thin.image_distance_m() / thin.focal_length_m;
}

class AberratedSampler;

/// Independent aberrations of an ideal lens, each with a closed form (lens_models/README.md). All zero, it is the thin
/// lens. The ray that meets the sensor at X after crossing the pupil at p (in radii; p_t along X, p_s across it) is the
/// ideal lens's ray for X / (1 + distortion) - delta, where delta(X, p) is the sum of the transverse aberrations below.
/// R is the pupil radius, z_i the image distance, h = |X| / field_radius_m, a measure of the chief ray's angle, on
/// which aberrations depend while the lens moves; beyond h = 1 all but the distortion stay as they are there.
struct Aberrations {
  double image_radius_mm = 3.528;  ///< of the picture of infinity

  double focus_um = 0;                 ///< focus surface minus sensor on the axis, + behind: delta = -R p dz / z_i
  EvenPolynomial tangential_focus_um;  ///< ... and over the field, for p along X
  EvenPolynomial sagittal_focus_um;    ///< ... for p across X
  /// The same three for each diopter (1/m) of focus: a lens made for infinity errs more as it focuses nearer.
  double focus_um_per_diopter = 0;
  EvenPolynomial tangential_focus_um_per_diopter, sagittal_focus_um_per_diopter;
  std::vector<double> spherical_um;  ///< c3, c5, ...: delta = (c3 rho^3 + c5 rho^5 + ...) p / rho, rho = |p|
  /// c1, c3, ...: delta = (c1 h + c3 h^3 + ...) (3 p_t^2 + p_s^2, 2 p_t p_s), along X and across it
  std::vector<double> coma_um;
  EvenPolynomial distortion;                      ///< (|X| - ideal) / ideal
  std::array<double, 2> longitudinal_color_um{};  ///< focus of R and of B minus that of G
  std::array<double, 2> lateral_color{};          ///< picture size of R and of B over that of G, minus 1
  /// From the sensor to the exit pupil while the lens is focused at infinity, mm: what tilts the light that a
  /// microlens sees. 0: the focal length.
  double exit_pupil_mm = 0;
  EvenPolynomial exit_pupil_growth;  ///< growth of that distance over the field: chief rays of phones are no pencil
  EvenPolynomial tangential_pupil;   ///< growth of the entrance pupil over the field, along X ...
  EvenPolynomial sagittal_pupil;     ///< ... and across it

  /// A round rim elsewhere in the lens, seen in the pupil: light passes where |p - shift h X/|X|| <= radius. Two discs
  /// make the cat's eye.
  struct Rim {
    double radius = 1;  ///< in pupil radii
    double shift = 0;   ///< at h = 1, in pupil radii
  };
  std::vector<Rim> rims;

  /// cos4: of the chief ray in front of the lens, times the growth of the pupil and the scene's solid angle that a
  /// photosite sees; disc: of each ray behind an ideal lens, which adds up to the exact law of the disc.
  enum class Falloff { none, cos4, disc } falloff = Falloff::none;
  FieldMap split_offset;                 ///< where the halves meet, in pupil radii: + gives the left view more light
  FieldMap left_gain{1}, right_gain{1};  ///< lens shading of each view, 0 ... 1

  using Sampler = AberratedSampler;

  static Aberrations read(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin);
  double radius_of_image_mm() const { return image_radius_mm; }
  void refocus(double, ThinLens&) {}
  bool has_color() const {
    return longitudinal_color_um != std::array<double, 2>{} || lateral_color != std::array<double, 2>{};
  }
};

inline constexpr Named<Aberrations::Falloff> kFalloffs[] = {
    {"none", Aberrations::Falloff::none, "the same light everywhere"},
    {"cos4", Aberrations::Falloff::cos4, "cos^4 of the chief ray, times the growth of the pupil"},
    {"disc", Aberrations::Falloff::disc, "the exact law of a disc, from each ray behind an ideal lens"},
};

}  // namespace dualpixel::simulator
