#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>

#include "simulator/lens/lens.h"
#include "simulator/sampling/sensor_grid.h"

/// The one interface through which rendering sees a lens, whatever its model: a position on the sensor and a position
/// in the pupil go in, a ray and its weight in each view come out, sixteen at a time.
namespace dualpixel::simulator {

struct LensPacket;

/// Copies share what was prepared.
class LensSampler {
 public:
  static constexpr int kRays = 16;  ///< of a LensPacket

  /// Prepares the model: up to a second for a prescription. Throws InputError where no light passes the lens.
  LensSampler(const Lens& lens, const SensorGrid& sensor);

  /// The same lens and sensor with another split pixel. Shares what was prepared: it takes no time.
  LensSampler with_split(const SplitPixel& split) const;

  /// The same lens over a part of the sensor. Likewise.
  LensSampler over(const SensorGrid& part) const;

  /// Rays of photosite (x, y) from sixteen points s of the unit 4-cube: two coordinates on the photosite, two on the
  /// pupil. `color`: 0 R, 1 G, 2 B; it matters where has_color(). `draw`: which wavelength of the filter's band all
  /// sixteen have, where the lens has several: any number, by turns.
  void sample(int x, int y, int color, const float s[4][kRays], LensPacket& out, std::uint32_t draw = 0) const;

  /// Whether rays bend at the stop; bend() does it to those of a photosite under filter `color`, by two uniform numbers
  /// each.
  bool diffracts() const;
  void bend(int color, const float u[kRays], const float v[kRays], LensPacket& rays) const;

  /// Rays of the ideal lens with the same chief rays: perfect focus, its pupil scaled (0: a pinhole), no shading.
  void sample_ideal(int x, int y, const float s[4][kRays], float aperture_scale, LensPacket& out) const;

  /// Slope in front of the lens of the green chief ray that ends at (x, y), in meters on the sensor.
  glm::dvec2 chief_slope(double x_m, double y_m) const;

  /// Illuminance on the axis of the sensor, in lux, per nit.
  double lux_per_nit() const;
  bool has_color() const;

  const Lens& lens() const;
  const SensorGrid& sensor() const;

 private:
  struct Prepared;
  explicit LensSampler(std::shared_ptr<const Prepared> prepared);
  std::shared_ptr<const Prepared> prepared_;
};

/// Share of the picture that the lens lights: of places all over it, those that get at least a hundredth of the light
/// that the axis gets, in green.
double lit_share(const LensSampler& lens);

}  // namespace dualpixel::simulator
