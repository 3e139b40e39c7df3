#pragma once
#include <array>

namespace dualpixel::simulator {

/// Catmull & Rom's cubic between the second and the third of four evenly spaced nodes, t from 0 to 1.
template <class Real>
std::array<Real, 4> cubic_weights(Real t) {
  const Real half = 0.5;
  return {t * (-half + t * (1 - half * t)), 1 + t * t * (-5 * half + 3 * half * t), t * (half + t * (2 - 3 * half * t)),
          t * t * (-half + half * t)};
}

/// Their derivatives by t.
template <class Real>
std::array<Real, 4> cubic_slopes(Real t) {
  const Real half = 0.5;
  return {-half + t * (2 - 3 * half * t), t * (-5 + 9 * half * t), half + t * (4 - 9 * half * t),
          t * (-1 + 3 * half * t)};
}

}  // namespace dualpixel::simulator
