#include "simulator/sensor/hand_shake.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace dualpixel::simulator::testing {
namespace {

/// Small turns about x, y, z and the shift along them.
std::array<double, 6> coordinates(const glm::dmat4& pose) {
  return {pose[1][2], pose[2][0], pose[0][1], pose[3][0], pose[3][1], pose[3][2]};
}

TEST(HandShake, StartsAtTheIdentityAndDependsOnItsArgumentsAlone) {
  EXPECT_EQ(hand_shake(7, 0, 1), glm::dmat4(1));
  EXPECT_EQ(hand_shake(7, 0.3, 0), glm::dmat4(1));
  EXPECT_EQ(hand_shake(7, 0.3, 1), hand_shake(7, 0.3, 1));
  EXPECT_NE(hand_shake(7, 0.3, 1), hand_shake(8, 0.3, 1));
  const glm::dmat4 pose = hand_shake(7, 0.3, 1);
  const glm::dmat4 product = glm::dmat4(glm::dmat3(pose)) * glm::transpose(glm::dmat4(glm::dmat3(pose)));
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(product[i][j], i == j, 1e-12);
  }
}

// Over 3000 paths: each of the six is Gaussian, so a mean square has a standard error of sqrt(2/3000) = 2.6 %; the
// tolerance is four of these. The displacement between two times far apart has twice the variance of the path.
TEST(HandShake, HasTheSpeedAndReachOfItsHeader) {
  constexpr int kPaths = 3000;
  std::array<double, 6> speed2{}, reach2{};
  for (int i = 0; i < kPaths; ++i) {
    const auto a = coordinates(hand_shake(i, 1e-3, 1)), far = coordinates(hand_shake(i, 40, 1));
    for (int k = 0; k < 6; ++k) {
      speed2[k] += a[k] * a[k] / 1e-6 / kPaths;
      reach2[k] += far[k] * far[k] / 2 / kPaths;
    }
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(speed2[k] / (0.015 * 0.015), 1, 4 * 0.026) << k;
    EXPECT_NEAR(reach2[3 + k] / (2e-4 * 2e-4), 1, 4 * 0.026) << k;
  }
}

// Even power over 0.5 .. 12 Hz: the mean square displacement after t is the integral of 2 (1 - cos wt) / w^2.
TEST(HandShake, HasAnEvenSpectrumOfSpeed) {
  constexpr int kPaths = 3000;
  for (const double time_s : {0.02, 0.05, 0.2}) {
    double expected = 0, measured = 0;
    for (int i = 0; i < 1000; ++i) {
      const double omega = 2 * M_PI * (0.5 + 11.5 * (i + 0.5) / 1000);
      expected += 2 * (1 - std::cos(omega * time_s)) / (omega * omega) / 1000 * 0.015 * 0.015;
    }
    for (int i = 0; i < kPaths; ++i) {
      const auto moved = coordinates(hand_shake(i, time_s, 1));
      for (int k = 0; k < 3; ++k) measured += moved[k] * moved[k] / (3 * kPaths);
    }
    EXPECT_NEAR(measured / expected, 1, 4 * 0.026 / std::sqrt(3)) << time_s;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
