#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

std::vector<std::array<float, 4>> joint_points(int count, std::uint64_t key) {
  std::vector<std::array<float, 4>> points;
  float block[4][kPacket];
  for (int first = 0; first < count; first += kPacket) {
    joint_samples(first, key, block);
    for (int i = 0; i < kPacket; ++i) points.push_back({block[0][i], block[1][i], block[2][i], block[3][i]});
  }
  return points;
}

// The first two dimensions are a (0, m, 2) net: each elementary interval of area 2^-m holds exactly one of 2^m points,
// and Owen scrambling keeps that.
TEST(Sobol, FirstTwoDimensionsFillElementaryIntervals) {
  constexpr int m = 8;
  const auto points = joint_points(1 << m, 42);
  for (int a = 0; a <= m; ++a) {
    std::vector<int> count(1 << m, 0);
    for (const auto& p : points) {
      const int x = static_cast<int>(p[0] * (1 << a));
      const int y = static_cast<int>(p[1] * (1 << (m - a)));
      ++count[x * (1 << (m - a)) + y];
    }
    EXPECT_EQ(*std::max_element(count.begin(), count.end()), 1);
  }
}

TEST(Sobol, MirroredPairsShareTheirPlaceAndOpposeEachOtherInThePupil) {
  const auto points = joint_points(64, 42);
  for (int first = 0; first < 64; first += 8) {
    float pairs[4][kPacket];
    mirrored_samples(first, 42, pairs);
    for (int i = 0; i < 8; ++i) {
      const int own = points[first + i][2] < 0.5f ? i : i + 8;  // the left half comes first
      EXPECT_LT(pairs[2][i], 0.5f);
      for (int d = 0; d < 4; ++d) {
        EXPECT_EQ(pairs[d][own], points[first + i][d]);
        EXPECT_NEAR(pairs[d][i + 8], d < 2 ? pairs[d][i] : 1 - pairs[d][i], 1e-6);
        EXPECT_GE(pairs[d][i + 8], 0);
        EXPECT_LT(pairs[d][i + 8], 1);
      }
    }
  }
}

TEST(Sobol, EveryDimensionIsStratified) {
  constexpr int n = 256;
  const auto points = joint_points(n, 7);
  for (int d = 0; d < 4; ++d) {
    std::vector<int> count(n, 0);
    for (const auto& p : points) ++count[static_cast<int>(p[d] * n)];
    EXPECT_EQ(*std::max_element(count.begin(), count.end()), 1) << "dimension " << d;
  }
}

// Lens dimensions (2, 3) are a (t, m, 2) net with t <= 2: quadrants of the pupil are shared out evenly.
TEST(Sobol, PupilQuadrantsGetEqualShares) {
  const auto points = joint_points(64, 3);
  int count[4] = {};
  for (const auto& p : points) ++count[(p[2] >= 0.5f) + 2 * (p[3] >= 0.5f)];
  for (int c : count) EXPECT_EQ(c, 16);
}

// In each half of the pupil by itself, and not at the same points.
TEST(Sobol, PaddedNetsAreStratifiedAndTheirOrderIsShuffled) {
  constexpr int n = 64;
  std::vector<int> count[2] = {std::vector<int>(n, 0), std::vector<int>(n, 0)};
  float u[kPacket], v[kPacket];
  int ascending = 0;
  for (int first = 0; first < n; first += kPacket / 2) {
    padded_samples(first, n - 1, 11, 0, u, v);
    for (int i = 0; i < kPacket; ++i) {
      ++count[i / 8][static_cast<int>(u[i] * 8) * 8 + static_cast<int>(v[i] * 8)];
      EXPECT_GE(v[i], 0);
      EXPECT_LT(v[i], 1);
      ascending += i % 8 > 0 && u[i] > u[i - 1];
      EXPECT_NE(u[i], u[(i + 8) % kPacket]);
    }
  }
  EXPECT_EQ(*std::max_element(count[0].begin(), count[0].end()), 1);
  EXPECT_EQ(*std::max_element(count[1].begin(), count[1].end()), 1);
  EXPECT_NEAR(ascending, 56, 4 * std::sqrt(112 * 0.25));
}

// A smooth function's error falls as for a net, far below 1/sqrt(N): at 1024 points random sampling errs by 0.0022.
TEST(Sobol, IntegratesASmoothFunctionOfAllFourDimensions) {
  double squared = 0;
  for (std::uint64_t key = 0; key < 16; ++key) {
    double sum = 0;
    for (const auto& p : joint_points(1024, key)) sum += p[0] * p[1] * p[2] * p[3];
    squared += std::pow(sum / 1024 - 1.0 / 16, 2);
  }
  EXPECT_LT(std::sqrt(squared / 16), 0.0022 / 10);
}

}  // namespace
}  // namespace dualpixel::simulator
