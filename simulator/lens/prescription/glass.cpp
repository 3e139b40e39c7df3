#include "simulator/lens/prescription/glass.h"

#include <cmath>

namespace dualpixel::simulator {

double refractive_index(const Glass& glass, double wavelength_nm) {
  const auto& v = glass.values;
  const double l2 = wavelength_nm * wavelength_nm * 1e-6;  // square micrometers
  switch (glass.kind) {
    case Glass::Kind::fixed:
      return v[0];
    case Glass::Kind::abbe: {
      if (v[1] == 0) return v[0];
      constexpr double d2 = 0.5875618 * 0.5875618, f2 = 0.4861327 * 0.4861327, c2 = 0.6562725 * 0.6562725;
      const double b = (v[0] - 1) / v[1] / (1 / f2 - 1 / c2);
      return v[0] + b * (1 / l2 - 1 / d2);
    }
    case Glass::Kind::sellmeier:
      return std::sqrt(1 + v[0] * l2 / (l2 - v[3]) + v[1] * l2 / (l2 - v[4]) + v[2] * l2 / (l2 - v[5]));
    case Glass::Kind::schott:
      return std::sqrt(v[0] + v[1] * l2 + v[2] / l2 + v[3] / (l2 * l2) + v[4] / (l2 * l2 * l2) +
                       v[5] / (l2 * l2 * l2 * l2));
  }
  return 1;
}

}  // namespace dualpixel::simulator
