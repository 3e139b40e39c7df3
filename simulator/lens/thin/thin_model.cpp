#include "simulator/lens/thin/thin_model.h"

#include <fmt/format.h>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/sampling/sobol.h"

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

ThinModel ThinModel::read(Fields& lens, const std::string&, double focus_distance_m, ThinLens& thin) {
  read_thin_lens(lens, focus_distance_m, thin);
  return {};
}

void read_thin_lens(Fields& lens, double focus_distance_m, ThinLens& thin) {
  double focal_length_mm = 4.442;
  thin.f_number = 1.8;
  lens.number("focal_length_mm", focal_length_mm, 0.1, 10000);
  lens.number("f_number", thin.f_number, 0.1, 1000);
  read_named(lens, "focusing", thin.focusing, kFocusings);
  thin.focal_length_m = focal_length_mm * 1e-3;
  if (!(focus_distance_m > thin.focal_length_m)) {
    lens.fail("focal_length_mm", fmt::format("{}: the focal length must be below focus_distance_m, {} m",
                                             focal_length_mm, focus_distance_m));
  }
  thin.focus_distance_m = focus_distance_m;
}

void set_focus(ThinLens& thin, double focus_distance_m) {
  thin.focus_distance_m = focus_distance_m;
  if (!(focus_distance_m * thin.pupil_magnification > thin.focal_length_m)) {
    throw InputError(fmt::format("focus distance: {} m: must be greater than the focal length, {:.6g} m",
                                 focus_distance_m, thin.focal_length_m));
  }
}

}  // namespace dualpixel::simulator
