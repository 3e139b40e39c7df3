#include "pipeline/defocus/highlights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace dualpixel::pipeline {
namespace {

/// Grey pixels whose brightness has P(v > x) = (x / start)^-a.
Image power_law(int side, double a, double start, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Image rgb(side, side, 3);
  for (std::size_t i = 0; i < rgb.data.size(); i += 3) {
    std::fill_n(&rgb.data[i], 3, static_cast<float>(start * std::pow(1 - uniform(random), -1 / a)));
  }
  return rgb;
}

Image clipped_at(Image rgb, float white) {
  for (float& value : rgb.data) value = std::min(value, white);
  return rgb;
}

// The gain against the mean of what was clipped, known here; the estimate of a from n pixels has a standard error of
// a / sqrt(n).
TEST(Highlights, GainIsTheMeanOfWhatWasClipped) {
  HighlightOptions options;
  options.clipped = 1;
  options.weight_px = 0;
  constexpr float kWhite = 1.25f;
  for (const double a : {0.8, 1.0, 1.5, 3.0}) {
    const Image light = power_law(300, a, 0.3, 4);
    double sum = 0, squares = 0, clipped = 0, bright = 0;
    for (std::size_t i = 0; i < light.data.size(); i += 3) {
      const double v = light.data[i] / kWhite;
      bright += v > 0.5;
      if (v < 1) continue;
      const double seen = std::min(v, options.most);
      clipped += 1;
      sum += seen;
      squares += seen * seen;
    }
    const double mean = sum / clipped;
    const double mean_error = std::sqrt((squares / clipped - mean * mean) / clipped);
    const double gain = highlight_gain(clipped_at(light, kWhite), kWhite, options);
    const double steeper = 1 + (1 - std::pow(options.most, 1 - 1.01 * a)) / (1.01 * a - 1);
    const double gentler = 1 + (1 - std::pow(options.most, 1 - 0.99 * a)) / (0.99 * a - 1);
    const double gain_error = (gentler - steeper) / 0.02 / std::sqrt(bright);  // by 1 % of a, times its relative error
    EXPECT_NEAR(gain, mean, 3 * std::hypot(mean_error, gain_error)) << a;
    EXPECT_GT(gain, 1.2);
  }
}

TEST(Highlights, OnlyClippedPixelsAreRaisedAndKeepTheirHue) {
  Image rgb(5, 1, 3, 0.4f), radius(5, 1, 1, 9.0f);
  for (const int x : {1, 3, 4}) rgb.at(x, 0, 0) = 1.25f;  // red clips alone
  rgb.at(2, 0, 1) = 1.2f;                                 // nearly
  radius.at(3, 0) = 2.7f;                                 // nearly in focus
  radius.at(4, 0) = 4.125f;                               // half the way
  const auto gain = static_cast<float>(highlight_gain(rgb, 1.25));
  EXPECT_GT(gain, 1.5f);
  const Image raised = recover_highlights(rgb, radius, 1.25);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(raised.at(0, 0, c), rgb.at(0, 0, c));
    EXPECT_EQ(raised.at(1, 0, c), gain * rgb.at(1, 0, c));
    EXPECT_EQ(raised.at(2, 0, c), rgb.at(2, 0, c));
    EXPECT_EQ(raised.at(3, 0, c), rgb.at(3, 0, c));
    EXPECT_FLOAT_EQ(raised.at(4, 0, c), (1 + gain) / 2 * rgb.at(4, 0, c));
  }
}

TEST(Highlights, BlackAndWhitePicturesHaveFiniteGains) {
  EXPECT_TRUE(std::isfinite(highlight_gain(Image(9, 9, 3), 1)));
  const double white = highlight_gain(Image(99, 99, 3, 1.0f), 1);
  EXPECT_GT(white, 1);
  EXPECT_LE(white, HighlightOptions().most);
  EXPECT_TRUE(std::isfinite(highlight_gain(Image(), 1)));
}

// A lamp sixteen times as bright as white, blurred by a true lens and then clipped, against the same from its clipped
// picture: recovered it is nearer to the truth, and white at most.
TEST(Highlights, BlurredLampsAreBrighter) {
  constexpr int kSide = 80;
  Image light(kSide, kSide, 3, 0.1f);
  for (int y = 38; y < 42; ++y) {
    for (int x = 38; x < 42; ++x) std::fill_n(&light.at(x, y), 3, 16.0f);
  }
  const Image seen = clipped_at(light, 1), disparity(kSide, kSide, 1, 1.0f), radius(kSide, kSide, 1, 10.0f);
  const BlurMapping mapping{10, 0, 0, 1, 10};
  const auto blurred = [&](const Image& rgb) {
    Defocused out = render_defocus(rgb, disparity, radius, mapping);
    clip_highlights(out, seen, 1);
    return out.rgb;
  };
  const Image truth = blurred(light), dull = blurred(seen), bright = blurred(recover_highlights(seen, radius, 1));
  const auto error = [&](const Image& image) {
    double sum = 0;
    for (std::size_t i = 0; i < image.data.size(); ++i) sum += std::abs(image.data[i] - truth.data[i]);
    return sum;
  };
  EXPECT_LT(error(bright), 0.95 * error(dull));
  EXPECT_LE(*std::max_element(bright.data.begin(), bright.data.end()), 1);
}

TEST(Highlights, WhatIsSharpStaysTheInputs) {
  const Image input = clipped_at(power_law(20, 1, 0.3, 9), 1);
  Defocused out{recover_highlights(input, Image(20, 20, 1, 9.0f), 1), Image(20, 20)};
  clip_highlights(out, input, 1);
  EXPECT_EQ(out.rgb.data, input.data);
}

}  // namespace
}  // namespace dualpixel::pipeline
