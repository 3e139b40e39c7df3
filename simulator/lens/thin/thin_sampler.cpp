#include "simulator/lens/thin/thin_sampler.h"

namespace dualpixel::simulator {

ThinSampler::ThinSampler(const ThinModel&, const ThinLens& thin, const SensorGrid&) : thin_(thin), sampled_(thin) {}

void ThinSampler::sample(const PixelFrame& f, int, const float s[4][kPacket], LensPacket& out,
                         PupilPacket& pupil) const {
  alignas(64) float p[2][kPacket];
  concentric_disc(s[2], s[3], p[0], p[1]);
  const float per_m = 1 / sampled_.image_distance_m;
  const float rim = sampled_.radius_m * per_m;
  for (int i = 0; i < kPacket; ++i) {
    out.origin_x[i] = p[0][i] * sampled_.radius_m;
    out.origin_y[i] = p[1][i] * sampled_.radius_m;
    out.slope_x[i] = (f.x_m + (s[0][i] - 0.5f) * f.pitch_m) * per_m - out.origin_x[i] * sampled_.inverse_focus;
    out.slope_y[i] = (f.y_m + (s[1][i] - 0.5f) * f.pitch_m) * per_m - out.origin_y[i] * sampled_.inverse_focus;
    pupil.p[i] = p[0][i];
    pupil.t[i] = p[0][i] * rim;
    pupil.weight[i] = 1;
  }
  pupil.chief_slope = f.x_m * per_m;
}

double ThinSampler::chief_slope_per_m(double) const { return 1 / thin_.image_distance_m(); }

}  // namespace dualpixel::simulator
