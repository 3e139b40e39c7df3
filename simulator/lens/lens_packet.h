#pragma once
#include <cstdint>

#include "simulator/sampling/packet.h"

/// What passes between the lens models, the split pixel and the renderer: one packet of sixteen samples of a photosite.
namespace dualpixel::simulator {

/// Rays of one pixel in camera axes, meters: they cross the entrance pupil's plane, z = 0, at (origin_x, origin_y), and
/// run along (slope_x, slope_y, 1), so that a hit's parameter is its planar depth. `left` and `right` are the ray's
/// weights in the two views, relative to the undivided pixel on the axis; both 0: the lens blocks it.
struct LensPacket {
  alignas(64) float origin_x[kPacket], origin_y[kPacket];
  alignas(64) float slope_x[kPacket], slope_y[kPacket];
  alignas(64) float left[kPacket], right[kPacket];
};

/// What all samples of one photosite share.
struct PixelFrame {
  float x_m, y_m;  ///< its center on the upright sensor, from the axis
  float pitch_m;
  float radial_x, radial_y;  ///< unit vector from the axis to it; (0, 1) on the axis
  double radius_m;           ///< distance from the axis
  std::uint32_t draw = 0;    ///< which of the wavelengths of a filter's band; any number, by turns
};

/// What the split pixel needs to know of a model's rays, besides the rays.
struct PupilPacket {
  alignas(64) float p[kPacket];       ///< position in the pupil along the split, pupil radii, right positive
  alignas(64) float t[kPacket];       ///< slope at the sensor relative to the chief ray's, along the split
  alignas(64) float weight[kPacket];  ///< light relative to that of the whole pupil on the axis; 0: blocked
  float chief_slope = 0;              ///< of the chief ray at the sensor, along the split
  float split_offset = 0;             ///< where the two halves meet, pupil radii
  float left_gain = 1, right_gain = 1;
};

}  // namespace dualpixel::simulator
