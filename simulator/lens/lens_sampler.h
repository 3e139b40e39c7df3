#pragma once
#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "simulator/lens/lens.h"
#include "simulator/lens/prescription/ray_polynomials.h"
#include "simulator/lens/prescription/ray_trace.h"
#include "simulator/sampling/packet.h"

/// The one door through which rendering sees a lens, whatever its model: a place on the sensor and a place in the pupil
/// go in, a ray and its share for each view come out, sixteen at a time.
namespace dualpixel::simulator {

/// Photosites on the sensor. Positions on it are upright: x right, y down as in the picture, 0 at the principal point.
struct SensorGrid {
  int width_px = 0;
  int height_px = 0;
  double pixel_pitch_m = 0;
  glm::dvec2 principal_point_px{0};  ///< continuous coordinates
  int dp_downsample_x = 2;           ///< photosites that a DP pixel is wide: the unit of disparity

  /// Where the middle of pixel (x, y) lies, metres from the axis, as the picture is upright.
  glm::dvec2 middle_m(double x, double y) const {
    return (glm::dvec2(x + 0.5, y + 0.5) - principal_point_px) * pixel_pitch_m;
  }
};

/// Rays of one pixel in camera axes, metres: they cross the entrance pupil's plane, z = 0, at (origin_x, origin_y), and
/// run along (slope_x, slope_y, 1), so that a hit's parameter is its planar depth. `left` and `right` say how much of
/// the ray's radiance each view receives, over what the axis of the whole pixel would; both 0: the lens blocks it.
struct LensPacket {
  alignas(64) float origin_x[kPacket], origin_y[kPacket];
  alignas(64) float slope_x[kPacket], slope_y[kPacket];
  alignas(64) float left[kPacket], right[kPacket];
};

class LensSampler {
 public:
  /// A prescription is searched for its pupils and fitted with polynomials here: up to a second. Throws
  /// std::invalid_argument where nothing passes the lens on its axis.
  LensSampler(const Lens& lens, const SensorGrid& sensor);

  /// Rays of photosite (x, y) from sixteen points s of the unit 4-cube: two coordinates on the photosite, two on the
  /// pupil. `color`: 0 R, 1 G, 2 B; it matters where has_color().
  void sample(int x, int y, int color, const float s[4][kPacket], LensPacket& out) const;

  /// Rays of the ideal lens with the same chief rays: perfect focus, its pupil scaled (0: a pinhole), no shading.
  void sample_ideal(int x, int y, const float s[4][kPacket], float aperture_scale, LensPacket& out) const;

  /// Slope in front of the lens of the green chief ray that ends at (x, y), in metres on the sensor.
  glm::dvec2 chief_slope(double x_m, double y_m) const;

  /// Illuminance on the axis of the sensor, in lux, per nit.
  double lux_per_nit() const { return lux_per_nit_; }
  bool has_color() const { return has_color_; }

  const Lens& lens() const { return lens_; }
  const SensorGrid& sensor() const { return sensor_; }

 private:
  struct PixelFrame;
  PixelFrame frame(int x, int y) const;
  void sample_thin(const PixelFrame& f, const float s[4][kPacket], LensPacket& out) const;
  void sample_aberrated(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out) const;
  void sample_polynomials(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out) const;
  void sample_traced(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out) const;
  /// Shares of the two views from the pupil coordinate p and the slope t; `weight` of each ray on top.
  void split(const PixelFrame& f, const float p[kPacket], const float t[kPacket], float excess_slope,
             const float weight[kPacket], LensPacket& out) const;

  Lens lens_;
  SensorGrid sensor_;
  double lux_per_nit_ = 0;
  bool has_color_ = false;
  float radius_m_ = 0;  ///< of the entrance pupil
  float image_distance_m_ = 0;
  float inverse_focus_ = 0;    ///< 1 / focus distance
  double field_radius_m_ = 0;  ///< of an aberrated lens: h = 1

  /// The split as a table over p or t, where it is neither hard nor a ramp.
  struct SplitTable {
    float low = 0, per_step = 0;  ///< first coordinate; 1 / spacing
    std::vector<float> left, right;
  } table_;

  // of a prescription, for R, G, B; one where it has no colour
  std::vector<RayPolynomials> polynomials_;
  std::vector<TracedLens<float>> traced_;
  double entrance_pupil_z_mm_ = 0;
  double axis_area_ = 0;              ///< dL dM of the green pass region on the axis
  std::vector<double> chief_slopes_;  ///< green, at PupilBounds' nodes
};

}  // namespace dualpixel::simulator
