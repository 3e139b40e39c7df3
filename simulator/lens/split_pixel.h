#pragma once
#include <algorithm>
#include <cmath>

namespace dualpixel::simulator {

/// How a photosite's two halves share the light that crossed the pupil at p = x / R, with x to the right in camera
/// axes and R the pupil radius. The right view takes w(p), the left view 1 - w(p): nothing is lost or made.
///   hard: w = 1 for p >= 0, else 0;             alpha = 4 / (3 pi)
///   ramp: w = (1 + p/k) / 2, k >= 1;            alpha = 1 / (4 k)      (see Wadhwa et al. 2018, Eq. 3, for alpha)
/// Real sensors split softly: measured phones have alpha = 0.19 ... 0.22, which the default k gives.
struct SplitPixel {
  enum class Kind { hard, ramp } kind = Kind::ramp;
  double k = 1.19;

  float right_weight(float p) const {
    return kind == Kind::hard ? (p >= 0 ? 1.0f : 0.0f) : 0.5f + 0.5f * p / static_cast<float>(k);
  }
  /// Centroid disparity over signed blur diameter, for a full circular pupil.
  double alpha() const { return kind == Kind::hard ? 4 / (3 * M_PI) : 1 / (4 * k); }
};

}  // namespace dualpixel::simulator
