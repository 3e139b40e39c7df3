#include "pipeline/defocus/highlights.h"
#include "pipeline/defocus/defocused.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/render.h"

namespace dualpixel::pipeline {
namespace {

/// Gray pixels whose brightness has P(v > x) = (x / start)^-a.
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

// The gain against the mean of what was clipped, known here; the estimate of a from n pixels that are not clipped has a
// standard error of a / sqrt(n).
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
      bright += v > 0.5 && v < 1;
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
  constexpr int kApart = 20;  // what is clipped is a lamp in the dark
  Image rgb(5 * kApart, 1, 3, 0.4f), radius(5 * kApart, 1, 1, 9.0f);
  for (const int x : {1, 3, 4}) rgb.at(kApart * x, 0, 0) = 1.25f;  // red clips alone
  rgb.at(2 * kApart, 0, 1) = 1.2f;                                 // nearly
  radius.at(3 * kApart, 0) = 2.7f;                                 // nearly in focus
  radius.at(4 * kApart, 0) = 4.125f;                               // half the way
  const auto gain = static_cast<float>(highlight_gain(rgb, 1.25));
  EXPECT_GT(gain, 1.5f);
  const Image raised = recover_highlights(rgb, radius, 1.25);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(raised.at(0, 0, c), rgb.at(0, 0, c));
    EXPECT_EQ(raised.at(kApart, 0, c), gain * rgb.at(kApart, 0, c));
    EXPECT_EQ(raised.at(2 * kApart, 0, c), rgb.at(2 * kApart, 0, c));
    EXPECT_EQ(raised.at(3 * kApart, 0, c), rgb.at(3 * kApart, 0, c));
    EXPECT_FLOAT_EQ(raised.at(4 * kApart, 0, c), (1 + gain) / 2 * rgb.at(4 * kApart, 0, c));
  }
}

// Skin in the sun: a bright patch whose light falls off gently, cut at white, against a lamp of the same size that
// light falls from within a few pixels, as a lens blurs it.
TEST(Highlights, SkinThatJustClipsIsNoLamp) {
  constexpr int kSide = 200;
  const auto bump = [](double x, double y, double radius) {
    return std::exp(-(x * x + y * y) / (2 * radius * radius));
  };
  Image rgb(kSide, kSide, 3);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double skin = 1.1 * bump(x - 50, y - 100, 40), lamp = 8 * bump(x - 160, y - 100, 3);
      rgb.at(x, y, 0) = static_cast<float>(std::min(skin + lamp, 1.0));
      rgb.at(x, y, 1) = static_cast<float>(std::min(0.8 * skin + lamp, 1.0));
      rgb.at(x, y, 2) = static_cast<float>(std::min(0.6 * skin + lamp, 1.0));
    }
  }
  const Image shares = lamp_shares(rgb, 1);
  EXPECT_EQ(shares.at(50, 100), 0);
  EXPECT_EQ(shares.at(160, 100), 1);
  EXPECT_EQ(shares.at(110, 100), 0);  // not clipped
  const Image radius(kSide, kSide, 1, 12.0f);
  const Image raised = recover_highlights(rgb, radius, 1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < 110; ++x) ASSERT_EQ(raised.at(x, y, 0), rgb.at(x, y, 0)) << x << " " << y;
  }
  EXPECT_FLOAT_EQ(raised.at(160, 100, 1), static_cast<float>(highlight_gain(rgb, 1)));
  // a patch that fills the picture has no surroundings to tell by
  EXPECT_EQ(lamp_shares(Image(9, 9, 3, 1.0f), 1).at(4, 4), 0);
}

TEST(Highlights, BlackAndWhitePicturesHaveFiniteGains) {
  EXPECT_TRUE(std::isfinite(highlight_gain(Image(9, 9, 3), 1)));
  const double white = highlight_gain(Image(99, 99, 3, 1.0f), 1);
  EXPECT_GT(white, 1);
  EXPECT_LE(white, HighlightOptions().most);
  EXPECT_TRUE(std::isfinite(highlight_gain(Image(), 1)));
}

// A lamp sixteen times as bright as white, blurred, against the same from its clipped picture.
TEST(Highlights, BlurredLampsAreBrighter) {
  constexpr int kSide = 80;
  Image light(kSide, kSide, 3, 0.1f);
  for (int y = 38; y < 42; ++y) {
    for (int x = 38; x < 42; ++x) std::fill_n(&light.at(x, y), 3, 16.0f);
  }
  const Image seen = clipped_at(light, 1), disparity(kSide, kSide, 1, 1.0f), radius(kSide, kSide, 1, 10.0f);
  const BlurMapping mapping{10, 0, 0, 1, 10};
  const auto blurred = [&](const Image& rgb, const Bokeh& bokeh) {
    return render_defocus(rgb, disparity, radius, mapping, {}, bokeh).rgb;
  };
  Bokeh recover;
  recover.recover_highlights = true;
  const Image truth = blurred(light, {}), dull = blurred(seen, {}), bright = blurred(seen, recover);
  // The disc's level is 0.1 + 16 (l - 0.1) / (pi 100) for a lamp of 4 x 4 px of light l: what is missing of it falls as
  // 16 - gain over 16 - 1.
  const auto at_middle = [](const Image& image) { return image.at(kSide / 2, kSide / 2, 0); };
  const double gain = highlight_gain(seen, 1);
  EXPECT_GT(gain, 1.5);
  EXPECT_NEAR((at_middle(truth) - at_middle(bright)) / (at_middle(truth) - at_middle(dull)), (16 - gain) / 15, 0.02);
}

// What is sharp stays the input's, bit for bit, and what is blurred is white at most: in both renderers, where a mask
// is soft, too.
TEST(Highlights, OnlyWhatIsBlurredChanges) {
  const Image input = clipped_at(power_law(40, 1, 0.3, 9), 1);
  Image disparity(40, 40), mask(40, 40);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      disparity.at(x, y) = x < 20 ? 0 : 1;
      mask.at(x, y) = std::clamp(static_cast<float>(x - 10) / 20, 0.0f, 1.0f);
    }
  }
  const BlurMapping mapping{8, 0, 0, 1, 8};
  Bokeh recover;
  recover.recover_highlights = true;
  const Image radius = blur_radii(disparity, mapping);
  const Defocused plain = render_defocus(input, disparity, radius, mapping);
  const Defocused by_depth = render_defocus(input, disparity, radius, mapping, {}, recover);
  const Defocused by_mask = blur_background(input, mask, {8, 40}, recover);
  EXPECT_NE(by_depth.rgb.data, plain.rgb.data);
  for (const Defocused* out : {&by_depth, &by_mask}) {
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 40; ++x) {
        for (int c = 0; c < 3; ++c) {
          if (out->blurred.at(x, y) == 0) {
            EXPECT_EQ(out->rgb.at(x, y, c), input.at(x, y, c));
          }
          EXPECT_LE(out->rgb.at(x, y, c), 1);
        }
      }
    }
  }
  // the last row is hardly blurred: its own pixels show, not raised ones
  for (int x = 0; x < 40; ++x) {
    const float share = by_mask.blurred.at(x, 39);
    EXPECT_LE(by_mask.rgb.at(x, 39, 0), (1 - share) * input.at(x, 39, 0) + share + 1e-6f);
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
