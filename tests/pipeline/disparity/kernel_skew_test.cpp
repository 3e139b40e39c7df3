#include "pipeline/disparity/kernel_skew.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/tile_disparity.h"
#include "tests/pipeline/ramp_pair.h"

namespace dualpixel::pipeline {
namespace {

// Moments of the right view's kernel summed over a grid of points of the pupil, which errs by 1e-3. At a blur so narrow
// the term in d^5 is a thousandth.
TEST(KernelSkew, IsTheThirdCentralMomentOfASplit) {
  constexpr int kSteps = 2000;
  for (const double k : {0.0, 0.5, 1.0, 1.19}) {
    double light = 0, x1 = 0, x3 = 0, y2 = 0, xy2 = 0, x2 = 0;
    for (int j = 0; j < kSteps; ++j) {
      for (int i = 0; i < kSteps; ++i) {
        const double x = (i + 0.5) / kSteps * 2 - 1, y = (j + 0.5) / kSteps * 2 - 1;
        if (x * x + y * y > 1) continue;
        const double weight = 1 + (k > 0 ? std::clamp(x / k, -1.0, 1.0) : std::copysign(1.0, x));
        light += weight;
        x1 += weight * x;
        x2 += weight * x * x;
        y2 += weight * y * y;
        x3 += weight * x * x * x;
        xy2 += weight * x * y * y;
      }
    }
    for (double* moment : {&x1, &x2, &y2, &x3, &xy2}) *moment /= light;
    const double xxx = x3 - 3 * x2 * x1 + 2 * std::pow(x1, 3), xyy = xy2 - x1 * y2;
    const double alpha = x1, radius = 0.1, d = 2 * alpha * radius, unit = std::pow(radius, 3);
    const KernelSkew skew = skew_of_split(std::min(alpha, kHalvesAlpha), 2).at(static_cast<float>(-d));
    EXPECT_NEAR(skew.xxx / unit, -xxx, 2e-3) << k;
    EXPECT_NEAR(skew.xyy / unit, -xyy / 4, 1e-3) << k;
  }
}

// The phase between the views, from the closed form of both kernels, by sums over 200 chords. Right at the farthest
// blur; before it two powers of d leave up to a sixth of what they describe.
TEST(KernelSkew, GivesTheShiftOfWaves) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (const double alpha : {0.1, kRampAlpha, 0.25, kHalvesAlpha}) {
    const SkewCurve curve = skew_of_split(alpha, 1);
    for (const double b : {-2.0, 4.0, 6.0}) {
      const double d = alpha * b;
      const KernelSkew skew = curve.at(static_cast<float>(d));
      const auto shift = [&](double fx, double fy) {
        const Response r = ramp_response(fx, fy, b, alpha);
        return 2 * std::atan2(r.odd, r.even) / (kTurn * fx);
      };
      const double along = d - std::pow(kTurn * 0.15, 2) * skew.xxx / 3;
      const double across = d - std::pow(kTurn * 0.15, 2) * skew.xyy;
      const auto tolerance = [&](double waves) { return b < 6 ? std::abs(waves - d) / 6 + 0.001 : 0.002; };
      EXPECT_NEAR(along, shift(0.15, 0), tolerance(shift(0.15, 0))) << alpha << ' ' << b;
      EXPECT_NEAR(across, shift(0.001, 0.15), tolerance(shift(0.001, 0.15))) << alpha << ' ' << b;
    }
  }
}

TEST(KernelSkew, IsLinearOverTheField) {
  SkewField field{2, 2, std::vector<SkewCurve>(4)};
  for (int i = 0; i < 4; ++i) field.nodes[i] = {{static_cast<float>(i), 1}, {0, 0, 2}, 1};
  EXPECT_FLOAT_EQ(field.at(0, 0).at(0.5f).xxx, 0.5f);
  EXPECT_FLOAT_EQ(field.at(1, 1).at(0.5f).xxx, 3.5f);
  EXPECT_FLOAT_EQ(field.at(0.25, 0.5).at(0).xxx, 1.25f);
  EXPECT_FLOAT_EQ(field.at(0.25, 0.5).at(9).xyy, 2);  // as at the farthest disparity
  EXPECT_FLOAT_EQ(SkewField().at(0.5, 0.5).at(1).xxx, 0);
}

TEST(KernelSkew, ScalesWithThePixels) {
  const SkewCurve curve = skew_of_split(kRampAlpha, 1), larger = in_larger_pixels(curve, 2);
  EXPECT_FLOAT_EQ(larger.at(0.5f).xxx, curve.at(1).xxx / 8);
  EXPECT_FLOAT_EQ(larger.at(0.5f).xyy, curve.at(1).xyy / 8);
  EXPECT_FLOAT_EQ(larger.farthest_dp_px, curve.farthest_dp_px / 2);
}

/// Median error of the tiles that are not at the border.
double bias(const RampPair& pair, const SkewField& skew) {
  LikelihoodMatchOptions options;
  options.range_px = 4;
  options.skew = skew;
  const Image found = match_by_likelihood(pair.left, pair.right, options).disparity_dp_px;
  std::vector<double> errors;
  for (int y = 1; y < found.height - 1; ++y) {
    for (int x = 2; x < found.width - 2; ++x) errors.push_back(found.at(x, y) - pair.disparity);
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  return errors[errors.size() / 2];
}

// Textures up to .2 cycles a pixel. The median of 1800 tiles, each with a standard deviation of .023, errs by .0007;
// the rest is what the moments leave of the kernels.
TEST(KernelSkew, TakesTheSplitOutOfTheMatch) {
  for (const double pixel_height : {1.0, 2.0}) {
    for (const double b : {3.0, -4.0, 5.0}) {
      const RampPair pair = ramp_pair(4, b, 0.003, kRampAlpha, pixel_height);
      EXPECT_GT(std::abs(bias(pair, {})), 0.018) << pixel_height << ' ' << b;  // as if they were shifts
      const double known = bias(pair, {1, 1, {skew_of_split(kRampAlpha, pixel_height)}});
      EXPECT_LT(std::abs(known), std::abs(b) < 5 ? 0.01 : 0.02) << pixel_height << ' ' << b;
    }
  }
}

// Whole shifts of each view are where interpolation's outermost tap comes and goes: .4 px were seen there.
TEST(KernelSkew, HoldsAtWholeShifts) {
  const SkewField skew{1, 1, {skew_of_split(kHalvesAlpha, 1)}};
  for (const double d : {1.99, 2.0, 2.01}) {
    const RampPair pair = ramp_pair(4, d / kHalvesAlpha, 0.003, kHalvesAlpha, 1);
    EXPECT_GT(bias(pair, {}), 0.025) << d;
    EXPECT_NEAR(bias(pair, skew), 0, 0.01) << d;
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
