#include "simulator/sensor_noise.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::simulator {

ErrorTarget sensor_noise(const Simulation& s, double lux_per_nit) {
  ErrorTarget target;
  for (int c = 0; c < 3; ++c) {
    const double electrons_per_nit = lux_per_nit * s.exposure.time_s * s.sensor.electrons_per_lux_s[c];
    const double after_gain_e = s.sensor.read_noise_after_gain_dn / gain_dn_per_electron(s.sensor, s.exposure.iso);
    const double read_nits = std::hypot(s.sensor.read_noise_e, after_gain_e) / electrons_per_nit;
    target.per_nit[c] = 1 / electrons_per_nit;
    target.constant[c] = std::max(read_nits * read_nits, 1e-12);
  }
  return target;
}

}  // namespace dualpixel::simulator
