#pragma once
#include <array>

namespace dualpixel::simulator {

/// What lies between two surfaces, by one of the usual dispersion formulas (wavelength in micrometers inside them):
///   fixed:      n
///   abbe:       n_d and V_d by Cauchy's two terms, n = A + B / lambda^2; V_d = 0 means no dispersion
///   sellmeier:  n^2 = 1 + sum_i K_i lambda^2 / (lambda^2 - L_i)
///   schott:     n^2 = a0 + a1 lambda^2 + a2 lambda^-2 + a3 lambda^-4 + a4 lambda^-6 + a5 lambda^-8
struct Glass {
  enum class Kind { fixed, abbe, sellmeier, schott } kind = Kind::fixed;
  std::array<double, 6> values = {1};  ///< n; n_d, V_d; K1, K2, K3, L1, L2, L3; a0 ... a5
};

double refractive_index(const Glass& glass, double wavelength_nm);

}  // namespace dualpixel::simulator
