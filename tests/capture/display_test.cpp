#include "capture/image/display.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dualpixel {
namespace {

/// IEC 61966-2-1, in double.
double srgb(double linear) { return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055; }

Image row_of(const std::vector<float>& values) {
  Image image(static_cast<int>(values.size()), 1);
  image.data = values;
  return image;
}

TEST(EncodeForDisplay, FollowsTheCurveWithinWhatTheHeaderStates) {
  Image linear(10007, 1);
  for (int x = 0; x < linear.width; ++x) linear.at(x, 0) = static_cast<float>(x) / static_cast<float>(linear.width - 1);
  const Image encoded = encode_for_display(linear);
  for (int x = 0; x < linear.width; ++x) ASSERT_NEAR(encoded.at(x, 0), srgb(linear.at(x, 0)), 3e-5) << linear.at(x, 0);
  EXPECT_EQ(encoded.at(0, 0), 0);
  EXPECT_FLOAT_EQ(encoded.at(linear.width - 1, 0), 1);
}

TEST(EncodeForDisplay, AStopDoublesTheLight) {
  const std::vector<float> values = {0.01f, 0.1f, 0.25f};
  const Image brighter = encode_for_display(row_of(values), {.exposure_ev = 1});
  const Image darker = encode_for_display(row_of(values), {.exposure_ev = -2});
  for (int x = 0; x < 3; ++x) {
    EXPECT_NEAR(brighter.at(x, 0), srgb(2.0 * values[x]), 3e-5);
    EXPECT_NEAR(darker.at(x, 0), srgb(0.25 * values[x]), 3e-5);
  }
}

TEST(EncodeForDisplay, WhatCannotBeShownIsBlackOrWhite) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Image encoded = encode_for_display(row_of({-1, -kInfinity, std::nanf(""), 1.5f, 1e30f, kInfinity}));
  for (int x = 0; x < 3; ++x) EXPECT_EQ(encoded.at(x, 0), 0) << x;
  for (int x = 3; x < 6; ++x) EXPECT_FLOAT_EQ(encoded.at(x, 0), 1) << x << ": but for the rounding of 1.055 - 0.055";
}

TEST(EncodeForDisplay, KeepsShapeAndChannels) {
  Image linear(3, 2, 3);
  linear.at(2, 1, 1) = 1;
  const Image encoded = encode_for_display(linear);
  EXPECT_EQ(encoded.channels, 3);
  for (std::size_t i = 0; i < linear.data.size(); ++i) EXPECT_FLOAT_EQ(encoded.data[i], linear.data[i]) << i;
}

}  // namespace
}  // namespace dualpixel
