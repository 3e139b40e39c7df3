#pragma once
#include <glm/glm.hpp>

#include "simulator/lens/lens.h"
#include "simulator/lens/split/split_sampler.h"

/// The one interface through which rendering sees a lens, whatever its model: a position on the sensor and a position
/// in the pupil go in, a ray and its weight in each view come out, sixteen at a time.
namespace dualpixel::simulator {

class LensSampler {
 public:
  /// Prepares the model: up to a second for a prescription. Throws InputError where no light passes the lens.
  LensSampler(const Lens& lens, const SensorGrid& sensor);

  /// Rays of photosite (x, y) from sixteen points s of the unit 4-cube: two coordinates on the photosite, two on the
  /// pupil. `color`: 0 R, 1 G, 2 B; it matters where has_color().
  void sample(int x, int y, int color, const float s[4][kPacket], LensPacket& out) const;

  /// Rays of the ideal lens with the same chief rays: perfect focus, its pupil scaled (0: a pinhole), no shading.
  void sample_ideal(int x, int y, const float s[4][kPacket], float aperture_scale, LensPacket& out) const;

  /// Slope in front of the lens of the green chief ray that ends at (x, y), in meters on the sensor.
  glm::dvec2 chief_slope(double x_m, double y_m) const;

  /// Illuminance on the axis of the sensor, in lux, per nit.
  double lux_per_nit() const;
  bool has_color() const { return has_color_; }

  const Lens& lens() const { return lens_; }
  const SensorGrid& sensor() const { return sensor_; }

 private:
  PixelFrame frame(int x, int y) const;

  Lens lens_;
  SensorGrid sensor_;
  SampledThinLens ideal_;
  SplitSampler split_;
  LensModelSampler model_;
  bool has_color_;
};

}  // namespace dualpixel::simulator
