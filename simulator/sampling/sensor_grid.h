#pragma once
#include <glm/glm.hpp>

/// Photosites on the sensor: the geometry that rendering needs.
namespace dualpixel::simulator {

/// Positions are upright, as in the picture: x right, y down, 0 at the principal point. Derived from SensorOptions by
/// sensor_grid(); an experiment may also lay one out itself, such as a part of a sensor.
struct SensorGrid {
  int width_px = 0;
  int height_px = 0;
  double pixel_pitch_m = 0;
  glm::dvec2 principal_point_px{0};  ///< continuous coordinates
  int dp_downsample_x = 2;           ///< photosites that a DP pixel is wide: the unit of disparity

  /// The center of pixel (x, y): meters from the axis, as the picture is upright.
  glm::dvec2 middle_m(double x, double y) const {
    return (glm::dvec2(x + 0.5, y + 0.5) - principal_point_px) * pixel_pitch_m;
  }
};

}  // namespace dualpixel::simulator
