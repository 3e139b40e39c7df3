#pragma once
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "simulator/lens/prescription/glass.h"

/// A lens prescription: surfaces of revolution about one axis. The lens frame has z along the axis
/// from the scene to the sensor, its origin at the first surface's vertex, and x, y as the camera has them: a point
/// (x, y, z) of it is (x, y, z_entrance_pupil - z) in camera axes.
namespace dualpixel::simulator {

/// z = c r^2 / (1 + sqrt(1 - (1 + conic) c^2 r^2)) + sum over terms of a r^power.
struct LensSurface {
  double curvature_per_mm = 0;  ///< c = 1 / radius; 0: plane
  double conic = 0;
  std::vector<std::pair<int, double>> terms;  ///< (power, coefficient in mm^(1 - power)), powers 2 ... 30
  double thickness_mm = 0;                    ///< to the next vertex, of the last one to the sensor; may be negative
  double semi_diameter_mm = 0;                ///< of the clear aperture: light outside it is blocked
  bool stop = false;                          ///< the aperture stop: its own plane in air, or one of the glass surfaces
  Glass after;
};

struct Prescription {
  std::vector<LensSurface> surfaces;       ///< in the order of the light
  double image_radius_mm = 0;              ///< of the sensor's circle that the lens was made for
  double reference_nm = 587.5618;          ///< of paraxial figures, of focusing and of the middle (green) ray
  std::array<double, 3> wavelengths_nm{};  ///< of R, G, B; equal: no color
  int band_samples = 1;                    ///< wavelengths that stand for each filter's band, odd
  double band_width_nm = 80;               ///< of that band
  int focus_gap = -1;         ///< the surface whose thickness focuses; the last one, or -1: the whole lens moves
  double focus_shift_mm = 0;  ///< by how much it is longer than in the design, which is focused on infinity

  int stop_index() const;
  /// Of filter `color`, the `sample`th of its band: in the middles of as many equal parts.
  double wavelength_nm(int color, int sample) const {
    return wavelengths_nm[color] + band_width_nm * ((sample + 0.5) / band_samples - 0.5);
  }
  bool has_color() const { return wavelengths_nm[0] != wavelengths_nm[1] || wavelengths_nm[1] != wavelengths_nm[2]; }
};

/// First-order figures at the reference wavelength, mm; z from the first vertex (Welford 1986, ch. 3).
struct Paraxial {
  double focal_length = 0;  ///< EFL
  double back_focus = 0;    ///< last vertex to rear focal point: BFL
  double front_focus = 0;   ///< first vertex to front focal point (negative for a usual lens): FFL
  double petzval_radius = 0;
  double entrance_pupil_z = 0;
  double entrance_pupil_diameter = 0;
  double entrance_pupil_scale = 0;  ///< its diameter over the stop's
  double exit_pupil_z = 0;
  double exit_pupil_diameter = 0;
  double exit_pupil_scale = 0;
  double f_number() const { return focal_length / entrance_pupil_diameter; }
};

Paraxial paraxial(const Prescription& lens);

/// Where an object on the axis at `object_z` (mm, lens frame; -infinity is allowed) is imaged, from the last vertex.
double paraxial_image_distance(const Prescription& lens, double object_z);

/// Why the lens cannot be stopped down to `f_number`, where it does not open so far.
std::optional<std::string> check_f_number(const Prescription& lens, double f_number);

/// The lens stopped down to `f_number`. Throws InputError where it does not open so far.
Prescription stopped_down(Prescription lens, double f_number);

/// The lens focused on `focus_distance_mm` from its entrance pupil: the focusing gap is set so that the paraxial image
/// moves back to where the design at infinity has it relative to the sensor (a design's sensor is a few microns off the
/// paraxial focus, at the best one). Throws InputError where the gap cannot do it.
Prescription focused(Prescription lens, double focus_distance_mm);

/// One readable line for each pair of neighboring surfaces that cross inside both clear apertures.
std::vector<std::string> overlaps(const Prescription& lens);

/// Height of the surface over its vertex plane at radius r, mm. Not finite beyond the conic's end.
double sag_mm(const LensSurface& surface, double r_mm);

}  // namespace dualpixel::simulator
