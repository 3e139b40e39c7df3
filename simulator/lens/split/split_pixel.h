#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/split_kinds.h"

namespace dualpixel::simulator {

/// How a photosite's two halves share the light that crossed the pupil. Two coordinates say where it crossed, both 0 on
/// the chief ray of the photosite's own position (microlenses are shifted to suit), both positive on the right (the
/// right view's) side in camera axes:
///   p  position in the pupil, in pupil radii;      t  slope of the ray at the sensor against the chief ray's.
///   hard        right takes all for p >= 0;                  alpha = 4 / (3 pi)
///   ramp        right takes (1 + p/k) / 2, k >= 1;           alpha = 1 / (4 k)
///   microlens   the disc of a lens of radius r, focal length f at height h over photodiodes of width w on either side
///               of the middle, lengths in photosite pitches: light that enters the lens at u lands at
///               x = u (1 - h/f) + h t - shift; right takes 0 < x < w, left -w < x < 0, the rest is lost. h = f with
///               a large w is the hard split.
///   table       measured shares over p, linear in between.
/// Weights never add up to more than 1. Real sensors split softly: a Pixel 4 has alpha = 0.203 ... 0.233
/// (lens_models/README.md), the default 0.21.
struct SplitPixel {
  SplitKind kind = SplitKind::ramp;
  double k = 1.19;

  struct Microlens {
    double focal_length = 1.44, height = 0.78, diode_width = 0.3, radius = 0.5, shift = 0;
    /// Distance of the exit pupil for which the microlenses are shifted; 0: for every lens's own chief rays.
    double design_exit_pupil_mm = 0;
  } microlens;

  struct Table {
    std::vector<double> p, left, right;  ///< of one length, p ascending from -1 or less to 1 or more
  } table;

  double crosstalk = 0;  ///< 0 ... 0.5: the part of each half's light that the other one gets

  struct Shares {
    double left, right;
  };
  /// `excess_slope`: of the chief ray over the one for which the microlens was shifted.
  Shares shares(double p, double t, double excess_slope = 0) const {
    Shares s{};
    switch (kind) {
      case SplitKind::hard:
        s.right = p >= 0 ? 1 : 0;
        s.left = 1 - s.right;
        break;
      case SplitKind::ramp:
        s.right = std::clamp(0.5 + 0.5 * p / k, 0.0, 1.0);
        s.left = 1 - s.right;
        break;
      case SplitKind::microlens: {
        // u is the abscissa of a point of a disc, so its distribution function is that of the half circle
        const double reach = std::max(microlens.radius * std::abs(1 - microlens.height / microlens.focal_length), 1e-9);
        const double center = microlens.height * (t + excess_slope) - microlens.shift;
        const auto below = [&](double x) {
          const double v = std::clamp((x - center) / reach, -1.0, 1.0);
          return 0.5 + (v * std::sqrt(1 - v * v) + std::asin(v)) / M_PI;
        };
        const double left_of_middle = below(0);
        s.right = below(microlens.diode_width) - left_of_middle;
        s.left = left_of_middle - below(-microlens.diode_width);
        break;
      }
      case SplitKind::table: {
        const auto upper = std::upper_bound(table.p.begin() + 1, table.p.end() - 1, p);
        const auto i = static_cast<std::size_t>(upper - table.p.begin());
        const double f = std::clamp((p - table.p[i - 1]) / (table.p[i] - table.p[i - 1]), 0.0, 1.0);
        s.left = table.left[i - 1] + f * (table.left[i] - table.left[i - 1]);
        s.right = table.right[i - 1] + f * (table.right[i] - table.right[i - 1]);
        break;
      }
    }
    return {s.left + crosstalk * (s.right - s.left), s.right + crosstalk * (s.left - s.right)};
  }

  /// Light of each half, any unit, from a full circular pupil whose rim has the slope `rim_slope` (1 / (2 N) at
  /// infinity).
  Shares light(double rim_slope) const { return over_pupil(rim_slope).light; }

  /// Centroid disparity over signed blur diameter behind that pupil: half the distance of the two centroids in p.
  double alpha(double rim_slope = 0) const {
    if (kind == SplitKind::hard) return (1 - 2 * crosstalk) * 4 / (3 * M_PI);
    if (kind == SplitKind::ramp) return (1 - 2 * crosstalk) / (4 * k);
    const auto [light, moment] = over_pupil(rim_slope);
    return light.left > 0 && light.right > 0 ? 0.5 * (moment.right / light.right - moment.left / light.left) : 0;
  }

 private:
  /// Sums over the pupil of the shares, and of the shares times p.
  struct Sums {
    Shares light{}, moment{};
  };
  Sums over_pupil(double rim_slope) const {
    constexpr int kSteps = 4096;
    Sums sums;
    for (int i = 0; i < kSteps; ++i) {
      const double p = (2 * i + 1.0) / kSteps - 1;
      const double chord = std::sqrt(1 - p * p);
      const Shares s = shares(p, p * rim_slope);
      sums.light.left += s.left * chord, sums.moment.left += s.left * chord * p;
      sums.light.right += s.right * chord, sums.moment.right += s.right * chord * p;
    }
    return sums;
  }
};

}  // namespace dualpixel::simulator
