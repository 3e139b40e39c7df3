#pragma once
#include <vector>

#include "simulator/lens/prescription/ray_counts.h"

/// What an optical designer asks of a lens, from exact rays in double precision: an object at infinity, at the angle
/// theta from the axis, the lens in the state that it is given in. Lengths in mm, lens frame, the field along +y.
namespace dualpixel::simulator {

struct Prescription;

struct FieldAnalysis {
  double theta_rad = 0;
  bool reached = false;              ///< whether a chief ray gets to the sensor; all below is 0 where not
  double chief_height = 0;           ///< of the ray through the stop's center, on the sensor
  double distortion = 0;             ///< its excess over focal length * tan(theta), as a fraction
  double chief_angle_rad = 0;        ///< at the sensor
  double tangential_focus = 0;       ///< parabasal focus of rays in the plane of the field, behind the sensor: +
  double sagittal_focus = 0;         ///< ... and across it
  double pupil_fraction = 0;         ///< of the beam's cross-section that passes, over the axis's
  double relative_illumination = 0;  ///< by counting directions from the sensor; holds cos^4 and vignetting
  double cos4 = 0;                   ///< of theta, beside it
  double centroid_height = 0;        ///< of the beam's spot
  double spot_rms = 0;               ///< about its centroid
  double spot_radius = 0;            ///< of its farthest ray
  RayCounts rays;                    ///< what became of the beam
};

std::vector<FieldAnalysis> analyze_fields(const Prescription& lens, double wavelength_nm,
                                          const std::vector<double>& theta_rad);

}  // namespace dualpixel::simulator
