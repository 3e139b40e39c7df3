#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/error.h"
#include "capture/image/demosaic.h"
#include "capture/image/display.h"
#include "capture/image/resample.h"
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/noise.h"
#include "pipeline/defocus/render.h"
#include "pipeline/defocus/scatter.h"
#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/portrait/plain_pair.h"
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
  EXPECT_DOUBLE_EQ(make_blur_mapping(5, 0, 2688, false).kappa, 24 * 1.82);
  EXPECT_DOUBLE_EQ(make_blur_mapping(1, 0, 2688, false).sharp_dp_px, 0.56 / 24);
  EXPECT_DOUBLE_EQ(make_blur_mapping(1, 0, 2688, true).sharp_dp_px, 0.19 / 24);
}

// The same picture with other numbers of pixels, and of DP pixels, has the same radius as a share of its width.
TEST(BlurRadius, DoesNotDependOnTheNumberOfPixels) {
  for (const double offset : {-0.9, -0.03, 0.01, 0.05, 0.4, 3.0}) {
    for (const double focus : {-0.4, 0.0, 0.3, 2.5}) {
      const double expected = make_blur_mapping(3, focus, 2688, true).radius_px(static_cast<float>(focus + offset));
      for (const auto& [width, px_per_dp_px] :
           {std::pair{1344, 2.0}, {672, 2.0}, {4032, 2.0}, {1344, 1.0}, {672, 4.0}}) {
        const double own = 2 / px_per_dp_px * width / 2688;  // DP px for one of the reference
        const BlurMapping mapping = make_blur_mapping(3, own * focus, width, true, {}, px_per_dp_px);
        EXPECT_NEAR(mapping.radius_px(static_cast<float>(own * (focus + offset))) * 2688 / width, expected, 2e-4)
            << offset << " " << focus << " " << width;
      }
    }
  }
}

/// Each pixel as four.
Image doubled(const Image& image) {
  Image out(2 * image.width, 2 * image.height, image.channels);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      for (int c = 0; c < image.channels; ++c) out.at(x, y, c) = image.at(x / 2, y / 2, c);
    }
  }
  return out;
}

/// RMS over all values.
double distance(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::pow(a.data[i] - b.data[i], 2);
  return std::sqrt(sum / static_cast<double>(a.data.size()));
}

// A picture of twice the size, blurred and reduced, is the picture blurred, by disparity and by mask, but for what the
// renderers' working picture of half the size adds: halving and enlarging again add a variance of 1 px^2 in x and in y
// (4 / 12 + 4 / 6) to the disc's r^2 / 4, here 25 to 36. Of the smaller picture's blur that is 3 to 4 % more than of
// the larger one's. Were the radius in pixels of its own, the larger picture's variance would be a quarter.
TEST(BlurStrength, DoesNotDependOnTheNumberOfPixels) {
  const int width = 1344, height = 64;
  Image picture(width, height, 3), disparity(width, height), mask(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double wave = std::sin(0.09 * x) * std::sin(0.07 * y + 0.02 * x);
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = static_cast<float>(0.4 + 0.3 * wave);
      disparity.at(x, y) = x < width / 3 ? 0.0f : 0.5f;
      mask.at(x, y) = x < width / 3 ? 1.0f : 0.0f;
    }
  }
  Image far = disparity;
  for (float& d : far.data) d *= 2;  // DP px are half as wide
  const Image large_picture = doubled(picture), large_disparity = doubled(far);
  const auto by_disparity = [](const Image& rgb, const Image& d) {
    const BlurMapping mapping = make_blur_mapping(1, 0, rgb.width, false);
    return render_defocus(rgb, d, blur_radii(d, mapping), mapping).rgb;
  };
  const Image small = by_disparity(picture, disparity);
  const Image reduced = resize_area(by_disparity(large_picture, large_disparity), width, height);
  EXPECT_LT(distance(reduced, small), 0.06 * distance(small, picture));
  for (const double face_px : {0.0, 280.0}) {
    const Image by_mask = blur_background(picture, mask, blur_for_face(face_px, width)).rgb;
    const Image large = blur_background(large_picture, doubled(mask), blur_for_face(2 * face_px, 2 * width)).rgb;
    EXPECT_LT(distance(resize_area(large, width, height), by_mask), 0.06 * distance(by_mask, picture)) << face_px;
  }
}

// Half a picture of odd sides, rounded up, reaches a pixel beyond it: what is blurred stays in its place.
TEST(Defocus, OddSidesShiftNothing) {
  for (const int side : {300, 301}) {
    for (const int at : {40, side - 40}) {
      Image picture(side, side, 3);
      for (int y = 0; y < side; ++y) std::fill_n(&picture.at(at, y), 3, 1.0f);
      for (int x = 0; x < side; ++x) std::fill_n(&picture.at(x, at), 3, 1.0f);
      const MaskBlurOptions options{.radius_px = 5.0 * MaskBlurOptions().reference_width_px / side};
      const Image out = blur_background(picture, Image(side, side), options).rgb;
      double light[2] = {}, moment[2] = {};
      for (int i = at - 12; i <= at + 12; ++i) {
        const float along[2] = {out.at(i, side / 2), out.at(side / 2, i)};
        for (int k = 0; k < 2; ++k) light[k] += along[k], moment[k] += (i - at) * along[k];
      }
      // of pixels at half size: half a pixel; the line across adds as much to both sides
      for (int k = 0; k < 2; ++k) EXPECT_LT(std::abs(moment[k] / light[k]), 0.51) << side << ' ' << at << ' ' << k;
    }
  }
}

// By the width of the picture as it is seen.
TEST(BlurRadius, OfAMaskIsTheSameInAPictureOnItsSide) {
  const Image picture(96, 64, 3, 0.3f);
  Image mask(96, 64);
  for (int y = 20; y < 50; ++y) std::fill_n(&mask.at(30, y), 30, 1.0f);
  const MaskBlurOptions options{.radius_px = 60};
  Bokeh on_its_side;
  on_its_side.aperture.transposed = true;
  const Defocused upright = blur_background(picture, mask, options);
  const Image back = transposed(blur_background(transposed(picture), transposed(mask), options, on_its_side).radius_px);
  for (std::size_t i = 0; i < upright.radius_px.data.size(); ++i) {
    EXPECT_NEAR(back.data[i], upright.radius_px.data[i], 1e-5);
  }
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

// What is in front hardly blurs: the band in focus reaches far to the front, and ends behind all the same.
TEST(Layers, AnUnblurredForegroundLeavesTheBackgroundItsBands) {
  BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  for (const double factor : {0.1, 0.01, 0.0}) {
    mapping.frontal_factor = factor;
    const std::vector<Band> bands = make_bands(-0.1, 1, mapping);
    const auto in_focus = std::find_if(bands.begin(), bands.end(), [](const Band& band) { return band.in_focus; });
    EXPECT_EQ(in_focus->alpha(0), 1);
    EXPECT_EQ(in_focus->alpha(-0.1f), 1);
    EXPECT_EQ(in_focus->alpha(static_cast<float>(4 * mapping.back_dp_px(5.5))), 0) << factor;
  }
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
  Layer layer;
  cut_band(rgb, disparity, radius, Image(3, 5, 1, 1.0f), band, layer);
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

TEST(Layers, SharesOfEveryPixelAddUpToOne) {
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  Image rgb(64, 2, 3, 0.5f), disparity(64, 2), radius(64, 2, 1, 4.0f);  // nothing is sharp
  for (int i = 0; i < 128; ++i) disparity.data[i] = static_cast<float>(-2 + 3 * (i % 64) / 63.0);
  const std::vector<Band> bands = make_bands(-2, 1, mapping);
  Layer layer;
  std::vector<float> sums(32);
  for (const Band& band : bands) {
    cut_band(rgb, disparity, radius, sums_of_tents(disparity, bands), band, layer);
    for (int x = 0; x < 32; ++x) sums[x] += layer.rgba.at(x, 0, 3);
  }
  for (const float sum : sums) EXPECT_NEAR(sum, 1, 1e-6);
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

Image over_nothing(void (*scatter)(const Layer&, Image&, const Aperture&), const Layer& layer,
                   const Aperture& aperture = {}) {
  Image out(layer.rgba.width, layer.rgba.height, 4);
  scatter(layer, out, aperture);
  return out;
}

/// Area of the pixel at (x, y) from its middle that lies within a disc.
double coverage(int x, int y, double radius) {
  constexpr int kSide = 32;
  const double reach = std::hypot(x, y);
  if (reach + 0.71 < radius) return 1;
  if (reach - 0.71 > radius) return 0;
  int inside = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const int column = i % kSide, line = i / kSide;
    const double u = x + (column + 0.5) / kSide - 0.5, v = y + (line + 0.5) / kSide - 0.5;
    inside += u * u + v * v < radius * radius;
  }
  return inside / (1.0 * kSide * kSide);
}

TEST(Scatter, GradientEqualsDirectScatterOfTheSameDiscs) {
  const int width = 90, height = 150;  // several strips
  Layer layer = random_layer(width, height, 1, 15);
  for (float& value : layer.rgba.data) value *= 0.3f;  // nothing piles up beyond 1
  // Rows -15 ... 15 of every radius that there is: area A and third moment of a disc's half chords within the row's
  // height, by the midpoint rule, make a row of half length sqrt(M / A).
  struct Row {
    double area = 0, moment = 0;
  };
  std::vector<std::array<Row, 31>> discs(15 * 8 + 1);
  for (std::size_t step = 0; step < discs.size(); ++step) {
    const double radius = std::max(static_cast<double>(step) / 8, 0.5);  // smaller discs lie within their pixel
    for (int i = 0; i < 31 * 300; ++i) {
      const double chord = std::sqrt(std::max(radius * radius - std::pow((i + 0.5) / 300 - 15.5, 2), 0.0));
      discs[step][i / 300].area += chord / 300;
      discs[step][i / 300].moment += chord * chord * chord / 300;
    }
  }
  Image direct(width, height, 4);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float radius = layer.radius_px.at(x, y);
      const double disc_area = std::numbers::pi * std::pow(std::max(radius, 0.5f), 2);
      for (int v = std::max(y - 15, 0); v <= std::min(y + 15, height - 1); ++v) {
        const Row& row = discs[std::lround(8 * radius)][v - y + 15];
        if (row.area == 0) continue;
        const double half = std::sqrt(row.moment / row.area);
        for (int u = std::max(x - 15, 0); u <= std::min(x + 15, width - 1); ++u) {
          const double length = std::max(std::min(half, u - x + 0.5) - std::max(-half, u - x - 0.5), 0.0);
          const auto share = static_cast<float>(length * row.area / half / disc_area);
          for (int c = 0; c < 4; ++c) direct.at(u, v, c) += layer.rgba.at(x, y, c) * share;
        }
      }
    }
  }
  const Image gradient = over_nothing(scatter_gradient, layer);
  for (std::size_t i = 0; i < direct.data.size(); ++i) ASSERT_NEAR(gradient.data[i], direct.data[i], 1e-4);
}

TEST(Scatter, KeepsEnergyInsideThePicture) {
  for (const float radius : {0.0f, 0.5f, 1.3f, 2.75f, 6.0f, 11.4f}) {
    Layer layer{Image(64, 64, 4), Image(64, 64, 1, radius)};
    for (int y = 20; y < 40; ++y) {
      for (int x = 20; x < 40; ++x) std::fill_n(layer.rgba.row(y) + 4 * x, 4, 0.8f);
    }
    const double before = 20 * 20 * 0.8;
    for (const Image& blurred : {over_nothing(scatter_direct, layer), over_nothing(scatter_gradient, layer)}) {
      double after = 0;
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) after += blurred.at(x, y, 2);
      }
      EXPECT_NEAR(after / before, 1, 1e-4) << radius;
    }
  }
}

// An impulse's disc against the ideal one, in the share that the two have in common of what either covers.
TEST(Scatter, ImpulsesBecomeDiscs) {
  for (const float radius : {2.75f, 2.8125f, 3.0f, 3.5f, 4.0f, 5.0f, 7.3125f, 12.0f, 15.0f}) {
    constexpr int kSide = 41, kMiddle = 20;
    Layer layer{Image(kSide, kSide, 4), Image(kSide, kSide, 1, radius)};
    std::fill_n(&layer.rgba.at(kMiddle, kMiddle), 4, 1.0f);
    for (const Image& disc : {over_nothing(scatter_direct, layer), over_nothing(scatter_gradient, layer)}) {
      double energy = 0, both = 0, either = 0, xx = 0, yy = 0;
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const double value = disc.at(x, y);
          const double ideal =
              coverage(x - kMiddle, y - kMiddle, radius) / (std::numbers::pi * static_cast<double>(radius * radius));
          energy += value;
          both += std::min(value, ideal);
          either += std::max(value, ideal);
          xx += value * (x - kMiddle) * (x - kMiddle);
          yy += value * (y - kMiddle) * (y - kMiddle);
        }
      }
      EXPECT_NEAR(energy, 1, 1e-5) << radius;
      EXPECT_GT(both / either, 0.92) << radius;
      // A uniform disc has variance r^2 / 4 along each axis, a pixel's square 1/12. Weights of
      // clamp(r + 1/2 - distance) are 2 % wider at r = 2.75.
      const double variance = 0.25 * radius * radius + 1.0 / 12;
      EXPECT_NEAR(xx / variance, 1, 0.03) << radius;
      EXPECT_NEAR(yy / variance, 1, 0.03) << radius;
    }
  }
}

TEST(Scatter, RadiusZeroLeavesThePixel) {
  const Layer layer = random_layer(20, 10, 3, 0);
  EXPECT_EQ(over_nothing(scatter_direct, layer).data, layer.rgba.data);
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
    // Red spreads over green: a disc whose center is 1.5 px beyond an edge has 43 % of its area across it.
    EXPECT_NEAR(out.rgb.at(41, y, 0), 0.43f, 0.04f);
    EXPECT_NEAR(out.rgb.at(41, y, 1), 0.57f, 0.04f);
    EXPECT_NEAR(out.blurred.at(41, y), 0.43f, 0.04f);  // the subject keeps its own noise
  }
}

// Leaves before a sky, whose light the lens mixes: each half of the picture, however many bands they are cut into.
TEST(Render, WhatIsSeenThroughGapsHasItsShareOfTheLight) {
  constexpr int kSide = 160;
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  Image rgb(kSide, kSide, 3), disparity(kSide, kSide), radius(kSide, kSide, 1, 20.0f);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool leaf = (x / 4 + y / 4) % 2 == 0;
      disparity.at(x, y) = leaf ? 0.7f : 1.0f;
      if (!leaf) std::fill_n(&rgb.at(x, y), 3, 1.0f);
    }
  }
  disparity.at(0, 0) = 1.3f;  // where the far band ends
  for (const int bands : {3, 5, 9}) {
    const Image blurred = render_defocus(rgb, disparity, radius, mapping, {.bands = bands}).rgb;
    for (int y = 60; y < 100; ++y) {
      // of the checkers' contrast a disc of 20 px leaves .81 * 2 J1(22) / 22, .015 at most
      for (int x = 60; x < 100; ++x) ASSERT_NEAR(blurred.at(x, y), 0.5, 0.02) << bands << " bands";
    }
  }
}

// A slanted fence before a wall: along the outline of its top half of the light is the fence's, wherever bands end.
TEST(Render, OutlinesCoverHalfHoweverManyBandsCutThem) {
  constexpr int kWidth = 300, kHeight = 160;
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  for (const double side : {1.0, -1.0}) {  // behind and in front of the focus
    Image rgb(kWidth, kHeight, 3), disparity(kWidth, kHeight), radius(kWidth, kHeight, 1, 20.0f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool fence = y >= kHeight / 2;
        const double deep = fence ? 0.3 + 0.4 * x / kWidth : 1.2;
        disparity.at(x, y) = static_cast<float>(side > 0 ? deep : deep - 1.5);
        if (fence) std::fill_n(&rgb.at(x, y), 3, 1.0f);
      }
    }
    for (const int bands : {3, 5, 9}) {
      const Image blurred = render_defocus(rgb, disparity, radius, mapping, {.bands = bands}).rgb;
      for (int x = 40; x < kWidth - 40; ++x) {
        const float middle = 0.5f * (blurred.at(x, kHeight / 2 - 1) + blurred.at(x, kHeight / 2));
        // symmetric, so that only rounding is left: 1e-5; "over" errs by .17
        EXPECT_NEAR(middle, 0.5, 1e-4) << bands << " bands, " << side << ", at " << x;
      }
    }
  }
}

TEST(Render, SmallestPicturesAreFinite) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 5000}, {5000, 3}, {0, 0}}) {
    const Setting setting(width, height);
    const Defocused out =
        render_defocus(Image(width, height, 3, 0.5f), setting.disparity, setting.radius, setting.mapping);
    for (const float value : out.rgb.data) ASSERT_NEAR(value, 0.5f, 1e-5);
  }
}

// A largest radius that no float is: as a float it may exceed itself, and such radii are valid.
TEST(Render, AnyLargestRadiusWillDo) {
  BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  mapping.r_max_px = 30.0 * 128 / 2688;
  const Image disparity(32, 32, 1, 1.0f);
  const Defocused out = render_defocus(Image(32, 32, 3, 0.5f), disparity, blur_radii(disparity, mapping), mapping);
  EXPECT_NEAR(out.rgb.at(16, 16, 0), 0.5f, 1e-5);
}

TEST(Render, NoKappaNoBlur) {
  BlurRadiusOptions none;
  none.scale_px_per_dp_px = 0;
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false, none);
  const Setting setting(60, 40);
  const Image radius = blur_radii(setting.disparity, mapping);
  for (const float value : radius.data) ASSERT_EQ(value, 0);
  const Image rgb = random_layer(60, 40, 4, 1).rgba;
  Image colors(60, 40, 3);
  std::copy_n(rgb.data.begin(), colors.data.size(), colors.data.begin());
  EXPECT_EQ(render_defocus(colors, setting.disparity, radius, mapping).rgb.data, colors.data);
}

// Documented: what has no disparity is in focus, radii are clamped. The rest of the picture is as it would be.
TEST(Render, BrokenMapsAreMended) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  for (const float broken : {kNan, kInf, -kInf}) EXPECT_EQ(mapping.radius_px(broken), broken == broken ? 30 : 0);
  Image rgb(90, 60, 3), disparity(90, 60, 1, 1.0f);
  std::mt19937 random(2);
  for (float& value : rgb.data) value = static_cast<float>(random() % 1000) / 1000;
  Image radius = blur_radii(disparity, mapping);
  Image good_disparity = disparity, good_radius = radius;
  int at = 0;
  for (const auto& [d, r] : {std::pair{kNan, 3.0f}, {kInf, 30.0f}, {-kInf, 30.0f}, {1.0f, kNan}, {1.0f, -1.0f}}) {
    disparity.at(10 * at, 30) = d;
    radius.at(10 * at, 30) = r;
    good_disparity.at(10 * at, 30) = d == 1 ? 1.0f : 0.0f;
    good_radius.at(10 * at++, 30) = 0;
  }
  radius.at(70, 30) = kInf;
  good_radius.at(70, 30) = 30;
  const Defocused mended = render_defocus(rgb, disparity, radius, mapping);
  EXPECT_EQ(mended.rgb.data, render_defocus(rgb, good_disparity, good_radius, mapping).rgb.data);
  EXPECT_EQ(mended.rgb.at(10, 30, 1), rgb.at(10, 30, 1));
  for (const float value : mended.rgb.data) ASSERT_TRUE(std::isfinite(value));

  EXPECT_THROW(render_defocus(rgb, Image(90, 59), radius, mapping), InputError);
  EXPECT_THROW(render_defocus(rgb, disparity, Image(1, 1), mapping), InputError);
  EXPECT_THROW(blur_background(rgb, Image(90, 59)), InputError);
}

// A face of 0.15 m at 1.2 m, in a picture 2688 px wide of 1.4 um photosites behind 4.4 mm: 4.4e-3 * 0.15 / 1.2 / 1.4e-6
// = 393 px. A pupil of 12.3 mm focused there blurs infinity to a disc of 12.3e-3 * 4.4e-3 / 1.2 / 1.4e-6 = 32.2 px.
TEST(MaskBlur, IsThatOfALensAtTheFacesDistance) {
  EXPECT_NEAR(blur_for_face(393, 2688).radius_px, 32.2 / 2, 0.05);
  EXPECT_NEAR(blur_for_face(393 / 2.0, 1344).radius_px, 32.2 / 2, 0.05);  // meant for the reference width
  EXPECT_DOUBLE_EQ(blur_for_face(2000, 2688).radius_px, 30);
  EXPECT_DOUBLE_EQ(blur_for_face(0, 2688).radius_px, 20);
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
  const Defocused out = blur_background(rgb, mask, options);
  for (int y = 0; y < 120; ++y) {
    EXPECT_EQ(out.rgb.at(30, y, 0), 1);
    EXPECT_NEAR(out.rgb.at(62, y, 0), 0, 1e-5);  // no red outside
    EXPECT_EQ(out.radius_px.at(59, y), 0);
  }
  EXPECT_NEAR(out.rgb.at(110, 0, 1), 0.5f, 0.01f);
  EXPECT_NEAR(out.rgb.at(110, 119, 1), 0, 0.01f);
  EXPECT_NEAR(out.radius_px.at(110, 0), 20, 0.1);

  const Defocused constant = blur_background(Image(41, 23, 3, 0.4f), Image(41, 23), options);
  for (const float value : constant.rgb.data) EXPECT_NEAR(value, 0.4f, 1e-5);
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

// A picture that was multiplied by 3 against lens shading: its noise was, too.
TEST(Noise, GrowsWithTheGainAgainstShading) {
  constexpr float kSignal = 0.3f, kShot = 1e-4f, kRead = 3e-5f, kGain = 3;
  Image rgb(400, 300, 3, kSignal), gain(400, 300, 1, 1.0f);
  for (int y = 150; y < 300; ++y) std::fill_n(gain.row(y), 400, kGain);
  add_noise(rgb, Image(400, 300, 1, 1.0f), make_noise_patches(7), {kShot, kRead, {1, 1, 1}}, gain);
  double variance[2] = {};
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) variance[y / 150] += std::pow(rgb.at(x, y, 1) - kSignal, 2) / (400 * 150);
  }
  // of kGain (shot noise of a signal of kSignal / kGain + read noise); tolerance as above
  const double expected = kGain * kGain * (kShot * kSignal / kGain + kRead) / (kShot * kSignal + kRead);
  EXPECT_NEAR(variance[1] / variance[0] / expected, 1, 0.07);
}

double mean_square(const Image& image, int x0, int x1) {
  double sum = 0;
  for (int y = 20; y < image.height - 20; ++y) {
    for (int x = x0; x < x1; ++x) sum += std::pow(image.at(x, y), 2);
  }
  return sum / ((image.height - 40.0) * (x1 - x0));
}

/// A gray wall in colors by this matrix, its left half in focus: the noise that the blur takes from the right half
/// comes back.
void expect_halves_alike(const Matrix3& matrix) {
  constexpr int kWidth = 480, kHeight = 320;
  constexpr double kSignal = 0.4, kShot = 2e-4, kRead = 1e-5;
  Image mosaic(kWidth, kHeight, 1, static_cast<float>(kSignal));
  add_white_noise(mosaic, 5, std::sqrt(kShot * kSignal + kRead));
  const Image camera_rgb = demosaic(mosaic, "RGGB");
  Image rgb(kWidth, kHeight, 3), disparity(kWidth, kHeight, 1, 1.0f);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) {
    const float* from = &camera_rgb.data[i / 3 * 3];
    for (int k = 0; k < 3; ++k) rgb.data[i] += static_cast<float>(matrix[3 * (i % 3) + k]) * from[k];
  }
  for (int y = 0; y < kHeight; ++y) std::fill_n(disparity.row(y), kWidth / 2, 0.0f);
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  Defocused out = render_defocus(rgb, disparity, blur_radii(disparity, mapping), mapping);
  const auto high_pass = [&](int channel) {
    Image plane(kWidth, kHeight);
    for (std::size_t i = 0; i < plane.data.size(); ++i) plane.data[i] = out.rgb.data[3 * i + channel];
    const Image coarse = gaussian_blur(plane, 3);
    for (std::size_t i = 0; i < plane.data.size(); ++i) plane.data[i] -= coarse.data[i];
    return plane;
  };
  // without noise the right half is smooth
  EXPECT_LT(mean_square(high_pass(1), 260, 460), 0.01 * mean_square(high_pass(1), 20, 220));
  add_noise(out.rgb, out.blurred, make_noise_patches(3), {kShot, kRead, {1, 1, 1}, matrix});
  // 200 x 280 pixels, of which a quarter are independent: 0.6 % of a sigma; the patches' 11 000: 1.5 %
  for (const int channel : {0, 1, 2}) {
    const Image fine = high_pass(channel);
    EXPECT_NEAR(std::sqrt(mean_square(fine, 260, 460) / mean_square(fine, 20, 220)), 1, 0.1) << channel;
  }
}

TEST(Noise, BlurredAndSharpHalvesAreAlikeUnderAHighPass) {
  expect_halves_alike(kIdentity3);
  expect_halves_alike({1.7, -0.5, -0.2, -0.3, 1.6, -0.3, 0, -0.6, 1.6});
}

// Patches that repeat as they are correlate by a third with themselves one period away.
TEST(Noise, HasNoPeriod) {
  constexpr int kWidth = 1800, kHeight = 1100;
  Image rgb(kWidth, kHeight, 3, 0.4f);
  add_noise(rgb, Image(kWidth, kHeight, 1, 1.0f), make_noise_patches(3), {1e-4, 0, {1, 1, 1}});
  const auto correlation = [&](int dx, int dy) {
    double product = 0, square = 0;
    for (int y = 0; y + dy < kHeight; ++y) {
      const float* here = rgb.row(y);
      const float* there = rgb.row(y + dy) + 3 * dx;
      for (int x = 0; x + dx < kWidth; ++x) {
        product += (here[3 * x + 1] - 0.4) * (there[3 * x + 1] - 0.4);
        square += std::pow(here[3 * x + 1] - 0.4, 2);
      }
    }
    return product / square;
  };
  // Demosaicking correlates pixels up to 4 apart. At a period, 400 tiles and more take either sign: 0.017.
  for (const int period : {59, 61, 67}) {
    for (const auto& [dx, dy] : {std::pair{period, 0}, {0, period}, {period, period}, {2 * period, 0}}) {
      EXPECT_LT(std::abs(correlation(dx, dy)), 0.05) << dx << ' ' << dy;
    }
  }
  for (const auto& [dx, dy] : {std::pair{5, 0}, {0, 5}, {8, 3}, {30, 0}, {0, 64}, {120, 128}, {128, 0}}) {
    EXPECT_LT(std::abs(correlation(dx, dy)), 0.05) << dx << ' ' << dy;
  }
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
