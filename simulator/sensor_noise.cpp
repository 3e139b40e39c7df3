#include "simulator/sensor_noise.h"

#include <algorithm>

namespace dualpixel::simulator {

ErrorTarget sensor_noise(const Simulation& s, double lux_per_nit) {
  const double gain = gain_dn_per_electron(s.sensor, s.exposure.iso);
  const double read_e2 = read_noise_dn2(s.sensor, s.exposure, false) / (gain * gain);
  ErrorTarget target;
  for (int c = 0; c < 3; ++c) {
    // of the filter's own color, in what is white in the scene's light
    double seen = 0;
    for (int k = 0; k < 3; ++k) seen += s.sensor.color_matrix[3 * c + k] * s.sensor.illuminant[k];
    const double electrons_per_nit =
        lux_per_nit * s.exposure.time_s * s.sensor.electrons_per_lux_s[c] * seen / s.sensor.illuminant[c];
    target.per_nit[c] = 1 / electrons_per_nit;
    target.constant[c] = std::max(read_e2 / (electrons_per_nit * electrons_per_nit), 1e-12);
  }
  return target;
}

}  // namespace dualpixel::simulator
