#pragma once
#include "simulator/lens/aberrated/aberrated_model.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/thin/thin_sampler.h"
#include "simulator/sampling/sensor_grid.h"

namespace dualpixel::simulator {

class AberratedSampler {
 public:
  AberratedSampler(const Aberrations& aberrations, const ThinLens& thin, const SensorGrid& sensor);
  void sample(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& rays, PupilPacket& pupil) const;
  double chief_slope_per_m(double radius_m) const;
  double lux_per_nit() const { return thin_.lux_per_nit(); }
  bool has_color() const { return aberrations_.has_color(); }

 private:
  /// What the aberrations come to at one photosite in one color; lengths in meters on the sensor.
  struct Local {
    double h;                              ///< field, not limited to 1
    double exit_pupil;                     ///< growth of its distance
    float per_m, rim;                      ///< 1 / image distance; slope of the pupil's rim
    float defocus_t, defocus_s;            ///< transverse shifts of the rim's ray, tangentially and sagittally
    float coma;                            ///< a third of the shift of the tangential rim's ray by coma
    float pupil_t, pupil_s;                ///< growth of the pupil
    float stretch_radial, stretch_around;  ///< of the ideal picture over the real one, for steps within the photosite
  };
  Local local_at(const PixelFrame& f, int color) const;
  /// Of sixteen samples, in pupil radii: in the picture's axes, and away from the axis and around it.
  struct CutPupil {
    alignas(64) float x[kPacket], y[kPacket], along[kPacket], across[kPacket];
    alignas(64) float area[kPacket];  ///< of the pupil that each stands for, over the whole
  };
  void draw_in(const Local& at, CutPupil& p) const;
  void weigh(const PixelFrame& f, const Local& at, const CutPupil& p, float weight[kPacket]) const;

  Aberrations aberrations_;
  ThinLens thin_;
  SampledThinLens sampled_;
  double field_radius_m_;  ///< h = 1
};

}  // namespace dualpixel::simulator
