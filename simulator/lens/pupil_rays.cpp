#include "simulator/lens/pupil_rays.h"

#include <algorithm>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {

PupilRays trace_pupil(const LensSampler& lens, int x, int y, int samples) {
  PupilRays pupil;
  alignas(64) float s[4][kPacket];
  LensPacket packet;
  for (int first = 0; first < samples; first += kPacket) {
    joint_samples(first, 0, s);
    std::fill(&s[0][0], &s[2][0], 0.5f);
    lens.sample(x, y, 1, s, packet);
    for (int i = 0; i < kPacket; ++i) {
      if (!(packet.left[i] > 0 || packet.right[i] > 0)) continue;
      pupil.rays.push_back({{packet.origin_x[i], packet.origin_y[i]},
                            {packet.slope_x[i], packet.slope_y[i]},
                            packet.left[i],
                            packet.right[i]});
    }
  }
  const double step_m = lens.sensor().pixel_pitch_m;
  const glm::dvec2 at = lens.sensor().middle_m(x, y);
  const glm::dmat2 slope_per_m(
      (lens.chief_slope(at.x + step_m, at.y) - lens.chief_slope(at.x - step_m, at.y)) / (2 * step_m),
      (lens.chief_slope(at.x, at.y + step_m) - lens.chief_slope(at.x, at.y - step_m)) / (2 * step_m));
  pupil.photosites_per_slope = glm::inverse(slope_per_m) / step_m;
  return pupil;
}

}  // namespace dualpixel::simulator
