#pragma once
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/thin/thin_model.h"
#include "simulator/sampling/sensor_grid.h"

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
  ThinSampler(const ThinModel& model, const ThinLens& thin, const SensorGrid& sensor);
  void sample(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& rays, PupilPacket& pupil) const;
  double chief_slope_per_m(double radius_m) const;
  double lux_per_nit() const { return thin_.lux_per_nit(); }
  bool has_color() const { return false; }

 private:
  ThinLens thin_;
  SampledThinLens sampled_;
};

}  // namespace dualpixel::simulator
