#pragma once
#include <array>
#include <vector>

#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/ray_trace.h"

/// Which directions, seen from a point of the sensor, lead through the lens to the scene. Aiming at the whole rear
/// element would waste 60 to 99.99 % of the rays; aiming at an ellipse of direction cosines for each distance from the
/// axis wastes few, and since irradiance is the integral of radiance over dL dM, the ellipse's area is the sample's
/// weight: relative illumination comes out by itself.
namespace dualpixel::simulator {

/// At a sensor point (0, r) of the lens frame: the pass region lies inside
///   (L / half_l)^2 + ((M - center_m) / half_m)^2 <= 1,       L, M direction cosines from the sensor to the scene.
/// All 0 where the lens passes nothing.
struct PupilEllipse {
  double chief_m = 0;  ///< of the ray through the stop's center
  double center_m = 0, half_m = 0, half_l = 0;
  double pass_area = 0;  ///< of the pass region, dL dM
};

struct PupilBounds {
  static constexpr int kNodes = 65;
  double image_radius_mm = 0;  ///< of the last node; nodes are evenly spaced from the axis
  std::array<PupilEllipse, kNodes> nodes;

  /// Cubic (Catmull & Rom) between nodes; pass_area linear.
  PupilEllipse at(double r_mm) const;
};

/// For one wavelength. Paths that reach the scene apart from the bundle round the chief ray (light that strays through
/// the rims of strong aspheres) are left out. Nodes reach to `image_radius_mm`.
PupilBounds find_pupil(const Prescription& lens, double wavelength_nm, double image_radius_mm);

/// Where the reverse ray from sensor point (0, r) through the center of the stop leaves the sensor: its cosine M,
/// searched near `guess`. NaN where there is none.
double chief_cosine(const TracedLens<double>& unclipped, double r_mm, double guess);

}  // namespace dualpixel::simulator
