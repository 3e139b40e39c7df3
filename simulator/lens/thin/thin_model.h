#pragma once
#include <string>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/thin/thin_lens.h"
#include "simulator/sampling/sensor_grid.h"

namespace dualpixel {
class Fields;
}

namespace dualpixel::simulator {

/// The figures of a thin lens in single precision, as samplers use them.
struct SampledThinLens {
  explicit SampledThinLens(const ThinLens& thin)
      : radius_m(static_cast<float>(0.5 * thin.pupil_diameter_m())),
        image_distance_m(static_cast<float>(thin.image_distance_m())),
        inverse_focus(static_cast<float>(1 / thin.focus_distance_m)) {}
  float radius_m;  ///< of the entrance pupil
  float image_distance_m;
  float inverse_focus;  ///< 1 / focus distance
};

class ThinSampler {
 public:
  ThinSampler(const struct ThinModel& model, const ThinLens& thin, const SensorGrid& sensor);
  void sample(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& rays, PupilPacket& pupil) const;
  double chief_slope_per_m(double radius_m) const;
  double lux_per_nit() const { return thin_.lux_per_nit(); }
  bool has_color() const { return false; }

 private:
  ThinLens thin_;
  SampledThinLens sampled_;
};

/// The ideal lens: all that it needs are the first-order figures.
struct ThinModel {
  static constexpr double kWork = 1;
  using Sampler = ThinSampler;

  static ThinModel read(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin);
  double radius_of_image_mm() const { return 0; }
  void refocus(double, ThinLens&) {}
};

/// Reads focal length, f-number and the way of focusing, for the models that build on an ideal lens.
void read_thin_lens(Fields& lens, double focus_distance_m, ThinLens& thin);

/// Throws InputError where the lens cannot focus so near.
void set_focus(ThinLens& thin, double focus_distance_m);

}  // namespace dualpixel::simulator
