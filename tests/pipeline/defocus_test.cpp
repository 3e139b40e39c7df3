#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/noise.h"
#include "pipeline/defocus/render.h"
#include "pipeline/defocus/scatter.h"
#include "pipeline/display.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

TEST(BlurRadius, ConstantsAreTheSupplements) {
  EXPECT_DOUBLE_EQ(kappa_1(2), 1);  // 0.83, clamped
  EXPECT_DOUBLE_EQ(kappa_1(5), 1.82);
  EXPECT_DOUBLE_EQ(kappa_1(INFINITY), 3.5);
  EXPECT_DOUBLE_EQ(kappa_2(0), 1);
  EXPECT_DOUBLE_EQ(kappa_2(-1), 1 / 1.5);  // the sign is turned: a focus in front weakens
  EXPECT_DOUBLE_EQ(kappa_2(0.5), 1 / 0.75);
  EXPECT_DOUBLE_EQ(kappa_2(-4), 0.5);
  EXPECT_DOUBLE_EQ(kappa_2(1.5), 2);
  EXPECT_DOUBLE_EQ(kappa_2(3), 2);
  EXPECT_DOUBLE_EQ(make_blur_mapping(1, 0, 2688, false).kappa, 24);
  EXPECT_DOUBLE_EQ(make_blur_mapping(5, 0, 1344, false).kappa, 12 * 1.82);
  EXPECT_DOUBLE_EQ(make_blur_mapping(1, 0, 2688, false).sharp_dp_px, 0.56 / 24);
  EXPECT_DOUBLE_EQ(make_blur_mapping(1, 0, 2688, true).sharp_dp_px, 0.19 / 24);
}

TEST(BlurRadius, FrontIsNegativeAndWeaker) {
  const BlurMapping mapping = make_blur_mapping(1, 0.1, 2688, false);
  const double kappa = 24 / 0.95;
  EXPECT_NEAR(mapping.radius_px(0.1f + 0.5f), kappa * 0.5 - 0.56, 1e-4);
  EXPECT_NEAR(mapping.radius_px(0.1f - 0.5f), 0.6 * (kappa * 0.5 - 0.56), 1e-4);
  EXPECT_EQ(mapping.radius_px(0.1f), 0);
  EXPECT_EQ(mapping.radius_px(0.1f + 0.02f), 0);
  EXPECT_EQ(mapping.radius_px(3), 30);
  EXPECT_EQ(mapping.radius_px(-3), 30);
  EXPECT_NEAR(mapping.radius_px(static_cast<float>(mapping.back_dp_px(5.5))), 5.5, 1e-5);
  EXPECT_NEAR(mapping.radius_px(static_cast<float>(mapping.front_dp_px(5.5))), 5.5, 1e-5);
}

TEST(Layers, BandsTileTheRangeAndTentsCoverIt) {
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  const std::vector<Band> bands = make_bands(-2, 1, mapping);
  ASSERT_EQ(bands.size(), 5u);
  EXPECT_NEAR(bands.back().low_dp_px, -2, 1e-12);
  int in_focus = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double beyond = i > 0 ? bands[i - 1].low_dp_px : 1;
    EXPECT_NEAR(bands[i].high_dp_px, beyond, 1e-12);  // far to near, no gaps
    EXPECT_NEAR(bands[i].taper_dp_px, 0.25 * (bands[i].high_dp_px - bands[i].low_dp_px), 1e-12);
    if (!bands[i].in_focus) continue;
    ++in_focus;
    EXPECT_NEAR(mapping.radius_px(static_cast<float>(bands[i].low_dp_px)), 5.5, 1e-4);
    EXPECT_NEAR(mapping.radius_px(static_cast<float>(bands[i].high_dp_px)), 5.5, 1e-4);
  }
  EXPECT_EQ(in_focus, 1);
  for (double d = -2; d <= 1; d += 0.01) {
    int full = 0;
    double sum = 0;
    for (const Band& band : bands) {
      full += band.alpha(static_cast<float>(d)) > 1 - 1e-5;
      sum += band.alpha(static_cast<float>(d));
    }
    EXPECT_GE(full, 1) << d;  // every disparity lies wholly in a band
    EXPECT_LE(sum, 2 + 1e-5) << d;
  }
  const Band band{0, 1, 0.25, false};
  EXPECT_FLOAT_EQ(band.alpha(1.125f), 0.5f);
  EXPECT_FLOAT_EQ(band.alpha(-0.25f), 0);
  EXPECT_FLOAT_EQ(band.alpha(0), 1);
}

TEST(Layers, BandsGoWhereTheDisparitiesAre) {
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  EXPECT_EQ(make_bands(-0.1, 0.1, mapping).size(), 1u);
  const std::vector<Band> behind = make_bands(0, 2, mapping);
  ASSERT_EQ(behind.size(), 5u);
  EXPECT_TRUE(behind.back().in_focus);
  const std::vector<Band> mostly_front = make_bands(-3, 0.3, mapping);
  EXPECT_TRUE(mostly_front[1].in_focus);
}

TEST(Layers, BlocksAreMeansAlsoAtOddBorders) {
  Image rgb(3, 5, 3, 0.5f), disparity(3, 5, 1, 0.0f), radius(3, 5, 1, 4.0f);
  const Band band{-1, 1, 0.5, false};
  disparity.at(0, 0) = 1.25f;  // alpha 1/2
  radius.at(0, 0) = 11;
  const Layer layer = make_layer(rgb, disparity, radius, band);
  ASSERT_EQ(layer.rgba.width, 2);
  ASSERT_EQ(layer.rgba.height, 3);
  for (const auto& [x, y] : {std::pair{1, 0}, {0, 2}, {1, 2}}) {
    EXPECT_FLOAT_EQ(layer.rgba.at(x, y, 3), 1);
    EXPECT_FLOAT_EQ(layer.rgba.at(x, y, 0), 0.5f);
    EXPECT_FLOAT_EQ(layer.radius_px.at(x, y), 2);  // half, at half resolution
  }
  EXPECT_FLOAT_EQ(layer.rgba.at(0, 0, 3), 3.5f / 4);
  EXPECT_FLOAT_EQ(layer.rgba.at(0, 0, 1), 0.5f * 3.5f / 4);
  EXPECT_FLOAT_EQ(layer.radius_px.at(0, 0), 0.5f * (0.5f * 11 + 3 * 4) / 3.5f);
}

Layer random_layer(int width, int height, unsigned seed, float largest_radius_px) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  Layer layer{Image(width, height, 4), Image(width, height)};
  for (std::size_t i = 0; i < layer.radius_px.data.size(); ++i) {
    const float alpha = uniform(random) < 0.3f ? 0 : uniform(random);
    for (int c = 0; c < 3; ++c) layer.rgba.data[4 * i + c] = alpha * uniform(random);
    layer.rgba.data[4 * i + 3] = alpha;
    layer.radius_px.data[i] = std::round(8 * largest_radius_px * uniform(random)) / 8;
  }
  return layer;
}

TEST(Scatter, GradientEqualsDirectScatterOfTheSameDiscs) {
  const int width = 90, height = 150;  // several strips
  const Layer layer = random_layer(width, height, 1, 15);
  Image direct(width, height, 4);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float radius = layer.radius_px.at(x, y);
      const int reach = static_cast<int>(radius);
      std::vector<std::pair<int, int>> disc;
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          if (static_cast<float>(dx * dx + dy * dy) <= radius * radius) disc.emplace_back(dx, dy);
        }
      }
      for (const auto& [dx, dy] : disc) {
        if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) continue;
        for (int c = 0; c < 4; ++c) {
          direct.at(x + dx, y + dy, c) += layer.rgba.at(x, y, c) / static_cast<float>(disc.size());
        }
      }
    }
  }
  const Image gradient = scatter_gradient(layer);
  for (std::size_t i = 0; i < direct.data.size(); ++i) ASSERT_NEAR(gradient.data[i], direct.data[i], 1e-4);
}

TEST(Scatter, KeepsEnergyInsideThePicture) {
  for (const float radius : {0.0f, 0.5f, 1.3f, 2.75f, 6.0f, 11.4f}) {
    Layer layer{Image(64, 64, 4), Image(64, 64, 1, radius)};
    for (int y = 20; y < 40; ++y) {
      for (int x = 20; x < 40; ++x) std::fill_n(layer.rgba.row(y) + 4 * x, 4, 0.8f);
    }
    const double before = 20 * 20 * 0.8;
    for (const Image& blurred : {scatter_direct(layer), scatter_gradient(layer)}) {
      double after = 0;
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) after += blurred.at(x, y, 2);
      }
      EXPECT_NEAR(after / before, 1, 1e-4) << radius;
    }
  }
}

TEST(Scatter, DiscsAreRoundAndOfTheirRadius) {
  for (const float radius : {2.0f, 5.0f, 12.0f}) {
    Layer layer{Image(61, 61, 4), Image(61, 61, 1, radius)};
    std::fill_n(&layer.rgba.at(30, 30), 4, 1.0f);
    for (const Image& disc : {scatter_direct(layer), scatter_gradient(layer)}) {
      double xx = 0, yy = 0;
      for (int y = 0; y < 61; ++y) {
        for (int x = 0; x < 61; ++x) {
          xx += disc.at(x, y) * (x - 30) * (x - 30);
          yy += disc.at(x, y) * (y - 30) * (y - 30);
        }
      }
      EXPECT_NEAR(xx, yy, 1e-4);
      // A uniform disc has variance r^2 / 4 along each axis; a rasterised one differs by its ragged rim.
      EXPECT_NEAR(2 * std::sqrt(xx), radius, 0.25) << radius;
    }
  }
}

TEST(Scatter, RadiusZeroLeavesThePixel) {
  const Layer layer = random_layer(20, 10, 3, 0);
  EXPECT_EQ(scatter_direct(layer).data, layer.rgba.data);
}

/// Disparities of every kind over a constant or given picture.
struct Setting {
  Image disparity, radius;
  BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  Setting(int width, int height) {
    disparity = textured(Texture(11, 0.02), width, height, 0, 0, 1.2);
    radius = blur_radii(disparity, mapping);
  }
};

TEST(Render, ConstantPictureStaysConstant) {
  for (const auto& [width, height] : {std::pair{201, 133}, {64, 48}}) {
    const Setting setting(width, height);
    const Defocused out =
        render_defocus(Image(width, height, 3, 0.37f), setting.disparity, setting.radius, setting.mapping);
    for (const float value : out.rgb.data) ASSERT_NEAR(value, 0.37f, 1e-5);
  }
}

TEST(Render, ZeroBlurIsTheInput) {
  std::mt19937 random(1);
  Image rgb(50, 40, 3);
  for (float& value : rgb.data) value = static_cast<float>(random() % 1000) / 1000;
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  const Defocused sharp = render_defocus(rgb, Image(50, 40, 1, 0.01f), Image(50, 40), mapping);
  EXPECT_EQ(sharp.rgb.data, rgb.data);
  for (const float blurred : sharp.blurred.data) EXPECT_EQ(blurred, 0);

  // A blurred background never reaches over a sharp subject.
  Image disparity(50, 40, 1, 1.0f);
  for (int y = 0; y < 40; ++y) std::fill_n(disparity.row(y), 25, 0.0f);
  const Defocused half = render_defocus(rgb, disparity, blur_radii(disparity, mapping), mapping);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 25; ++x) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(half.rgb.at(x, y, c), rgb.at(x, y, c));
    }
    for (int x = 28; x < 50; ++x) EXPECT_EQ(half.blurred.at(x, y), 1);
  }
}

TEST(Render, SubjectDoesNotBleedIntoTheBackgroundButABlurredFrontCoversTheSubject) {
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  Image rgb(120, 40, 3), disparity(120, 40);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 120; ++x) {
      const int part = x / 40;  // front: red; subject: green; background: blue
      rgb.at(x, y, part) = 1;
      disparity.at(x, y) = part == 0 ? -1.0f : part == 1 ? 0.0f : 1.0f;
    }
  }
  const Defocused out = render_defocus(rgb, disparity, blur_radii(disparity, mapping), mapping);
  for (int y = 0; y < 40; ++y) {
    for (int x = 82; x < 120; ++x) EXPECT_NEAR(out.rgb.at(x, y, 2), 1, 1e-5) << x;
    EXPECT_EQ(out.rgb.at(78, y, 1), 1);
    if (y < 15 || y >= 25) continue;  // elsewhere discs of radius 14 px are cut by the border
    // Red spreads over green: a disc whose centre is 1.5 px beyond an edge has 43 % of its area across it.
    EXPECT_NEAR(out.rgb.at(41, y, 0), 0.43f, 0.04f);
    EXPECT_NEAR(out.rgb.at(41, y, 1), 0.57f, 0.04f);
  }
}

TEST(Render, SmallestPicturesAreFinite) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 5000}}) {
    const Setting setting(width, height);
    const Defocused out =
        render_defocus(Image(width, height, 3, 0.5f), setting.disparity, setting.radius, setting.mapping);
    for (const float value : out.rgb.data) ASSERT_NEAR(value, 0.5f, 1e-5);
  }
}

TEST(MaskBlur, PersonAndBottomStaySharpAndNothingBleeds) {
  Image rgb(160, 120, 3), mask(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      mask.at(x, y) = x < 60 ? 1 : 0;
      rgb.at(x, y, x < 60 ? 0 : 1) = x < 60 ? 1.0f : static_cast<float>(x % 2);
    }
  }
  MaskBlurOptions options;
  options.reference_width_px = 160;
  const MaskBlurred out = blur_background(rgb, mask, options);
  for (int y = 0; y < 120; ++y) {
    EXPECT_EQ(out.picture.rgb.at(30, y, 0), 1);
    EXPECT_NEAR(out.picture.rgb.at(62, y, 0), 0, 1e-5);  // no red outside
    EXPECT_EQ(out.radius_px.at(59, y), 0);
  }
  EXPECT_NEAR(out.picture.rgb.at(110, 0, 1), 0.5f, 0.01f);
  EXPECT_NEAR(out.picture.rgb.at(110, 119, 1), 0, 0.01f);
  EXPECT_NEAR(out.radius_px.at(110, 0), 20, 0.1);

  const MaskBlurred constant = blur_background(Image(41, 23, 3, 0.4f), Image(41, 23), options);
  for (const float value : constant.picture.rgb.data) EXPECT_NEAR(value, 0.4f, 1e-5);
}

TEST(Noise, PatchesRepeatWithoutSeamsAndHaveDemosaickedNoisesLevel) {
  const std::vector<NoisePatch> patches = make_noise_patches(1);
  ASSERT_EQ(patches.size(), 3u);
  double variance[3] = {};
  for (const NoisePatch& patch : patches) {
    double seam = 0, inside = 0;
    for (int y = 0; y < patch.height; ++y) {
      const auto step = [&](int a, int b) { return std::pow(patch.at(a, y, 1) - patch.at(b, y, 1), 2); };
      seam += step(patch.width - 1, 0);
      for (int x = 1; x < patch.width; ++x) inside += step(x - 1, x) / (patch.width - 1);
    }
    EXPECT_NEAR(seam / inside, 1, 0.5);  // 59 samples: 0.18 standard deviations, times correlation
    for (int c = 0; c < 3; ++c) {
      for (int i = 0; i < patch.width * patch.height; ++i) {
        variance[c] += std::pow(patch.data[3 * i + c], 2) / (patch.width * patch.height);
      }
    }
  }
  // Malvar's filters on white noise of variance 1: green keeps 1 at half the sites and gets 36/64 at the others; red 1
  // at a quarter, (25 + 32 + 4 + 2 + 0.5) / 64 at half, (36 + 16 + 9) / 64 at a quarter. Three patches of about 3900
  // pixels: 1.3 %, more as they are correlated; the high pass takes 0.5 %.
  EXPECT_NEAR(variance[1], (1 + 36.0 / 64) / 2, 0.05);
  EXPECT_NEAR(variance[0], 0.25 + 0.5 * 63.5 / 64 + 0.25 * 61.0 / 64, 0.06);
}

TEST(Noise, FollowsTheProfileWhereBlurred) {
  Exposure exposure;
  exposure.black_level_dn = 64;
  exposure.white_level_dn = 1023;
  exposure.mosaic_noise = {0.16, 40};
  exposure.white_balance = {2, 1, 1.5};
  const NoiseLevel level = merged_noise(exposure, 9);
  const float signal = 0.3f;
  Image rgb(400, 300, 3, signal), blurred(400, 300, 1, 1.0f);
  for (int y = 0; y < 150; ++y) std::fill_n(blurred.row(y), 400, 0.0f);
  add_noise(rgb, blurred, make_noise_patches(7), level);
  for (int i = 0; i < 400 * 150 * 3; ++i) ASSERT_EQ(rgb.data[i], signal);
  double variance[3] = {};
  for (int i = 400 * 150; i < 400 * 300; ++i) {
    for (int c = 0; c < 3; ++c) variance[c] += std::pow(rgb.data[3 * i + c] - signal, 2) / (400 * 150);
  }
  const auto expected = [&](double gain) {
    return gain * gain * (0.16 * (signal / gain) * 959 + 40) * (0.3816 * 0.3816) / (959.0 * 959);
  };
  // Patches repeat, so they count as about 12 000 correlated samples: 1.3 % and more.
  EXPECT_NEAR(variance[1] / (expected(1) * 0.78125), 1, 0.07);
  EXPECT_NEAR(variance[0] / (expected(2) * 0.984), 1, 0.07);
}

TEST(Display, IsTheSrgbCurve) {
  Image linear(1001, 1);
  for (int x = 0; x <= 1000; ++x) linear.at(x, 0) = static_cast<float>(x) / 1000;
  const Image encoded = encode_for_display(linear);
  for (int x = 0; x <= 1000; ++x) {
    const double v = x / 1000.0;
    EXPECT_NEAR(encoded.at(x, 0), v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055, 3e-5);
  }
  linear.data = {-1, 7, std::numeric_limits<float>::quiet_NaN()};
  linear.width = 3;
  const Image ends = encode_for_display(linear);
  EXPECT_EQ(ends.data[0], 0);
  EXPECT_FLOAT_EQ(ends.data[1], 1);
  EXPECT_EQ(ends.data[2], 0);
  EXPECT_NEAR(encode_for_display(Image(1, 1, 1, 0.25f), {1}).data[0], 1.055 * std::pow(0.5, 1 / 2.4) - 0.055, 3e-5);
}

}  // namespace
}  // namespace dualpixel::pipeline
