#include "evaluation/metrics/edge_metrics.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dualpixel::evaluation {
namespace {

/// A step from 0 to `height` that takes `width_px` pixels, the middle at column 64.
Image step(double height, double width_px) {
  Image image(128, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 128; ++x) {
      const double along = width_px > 0 ? (x + 0.5 - 64) / width_px + 0.5 : x >= 64;
      image.at(x, y) = static_cast<float>(height * std::clamp(along, 0.0, 1.0));
    }
  }
  return image;
}

TEST(EdgeMetrics, MeasuresTheWidthOfRamps) {
  const Image truth = step(1, 0);
  EXPECT_NEAR(edge_width_px(truth, truth, 0.2f), 0.8, 1e-5);  // 80 % of the way between two neighbors
  EXPECT_NEAR(edge_width_px(step(1, 10), truth, 0.2f), 8, 1e-4);
  EXPECT_NEAR(edge_width_px(step(-1, 10), step(-1, 0), 0.2f), 8, 1e-4);
  EXPECT_NEAR(edge_width_px(step(0.7, 10), truth, 0.2f), 8, 1e-4);  // of its own step, not of the true one
  EXPECT_EQ(edge_width_px(Image(128, 64), truth, 0.2f), 32);        // no step at all: as wide as is looked
  EXPECT_EQ(edge_width_px(truth, Image(128, 64), 0.2f), 0);
}

Mask square(int left, int right) {
  Mask mask(64, 64);
  for (int y = 16; y < 48; ++y) {
    for (int x = left; x < right; ++x) mask.at(x, y) = 1;
  }
  return mask;
}

TEST(EdgeMetrics, BoundariesMatchWithinTheirReach) {
  EXPECT_EQ(boundary_f_score(square(16, 48), square(16, 48), 0), 1);
  EXPECT_EQ(boundary_f_score(square(16, 48), square(18, 50), 2), 1);
  // Shifted by 8: the sides, and 8 of the 32 pixels of top and bottom less 2 at the end, are off; the same both ways.
  const double boundary = 4 * 32 - 4, off = 32 + 2 * (8 - 2) - 2;
  EXPECT_NEAR(boundary_f_score(square(16, 48), square(24, 56), 2), (boundary - off - (32 - 2 - 4)) / boundary, 1e-12);
  EXPECT_EQ(boundary_f_score(Mask(64, 64), Mask(64, 64), 2), 1);
  EXPECT_EQ(boundary_f_score(Mask(64, 64), square(16, 48), 2), 0);
}

TEST(EdgeMetrics, ThinIsWhatFallsOutOfTheMedian) {
  Image map(64, 64);
  for (int y = 0; y < 64; ++y) {
    map.at(20, y) = map.at(21, y) = 1;               // thinner than half the window
    for (int x = 40; x < 60; ++x) map.at(x, y) = 1;  // wider
  }
  const Mask thin = thin_structures(map, 0.2f);
  for (int y = 10; y < 54; ++y) {
    for (int x = 0; x < 64; ++x) EXPECT_EQ(thin.at(x, y), x == 20 || x == 21) << x;
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
