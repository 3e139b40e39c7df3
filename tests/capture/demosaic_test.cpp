#include <gtest/gtest.h>

#include "capture/image/demosaic.h"

namespace dualpixel {
namespace {

/// A mosaic whose photosites see color(x, y, channel).
template <typename Color>
Image mosaic_of(int width, int height, const std::string& cfa, const Color& color) {
  Image mosaic(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const char name = cfa[2 * (y % 2) + x % 2];
      mosaic.at(x, y) = color(x, y, name == 'R' ? 0 : name == 'G' ? 1 : 2);
    }
  }
  return mosaic;
}

class DemosaicEachPattern : public testing::TestWithParam<std::string> {};

TEST_P(DemosaicEachPattern, FlatColorIsExactUpToTheBorder) {
  const float flat[3] = {0.25f, 0.5f, 0.75f};
  const Image rgb = demosaic(mosaic_of(12, 8, GetParam(), [&](int, int, int c) { return flat[c]; }), GetParam());
  // The gradient correction is a Laplacian of one color: 0 here, so no channel leaks into another.
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 12; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb.at(x, y, c), flat[c], 1e-6) << x << ' ' << y << ' ' << c;
    }
  }
}

TEST_P(DemosaicEachPattern, LinearRampIsExactInside) {
  const auto ramp = [](int x, int y, int c) {
    return 0.125f * static_cast<float>(c) + 0.015625f * static_cast<float>(x) - 0.0078125f * static_cast<float>(y);
  };
  const Image rgb = demosaic(mosaic_of(16, 12, GetParam(), ramp), GetParam());
  for (int y = 2; y < 10; ++y) {
    for (int x = 2; x < 14; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb.at(x, y, c), ramp(x, y, c), 1e-6) << x << ' ' << y << ' ' << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Demosaic, DemosaicEachPattern, testing::Values("RGGB", "BGGR", "GRBG", "GBRG"));

TEST(Demosaic, SmallestMosaicsAreFinite) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {3, 7}}) {
    const Image rgb = demosaic(Image(width, height, 1, 0.5f), "RGGB");
    for (const float value : rgb.data) EXPECT_NEAR(value, 0.5f, 1e-6);
  }
}

TEST(WhiteBalance, ClipsWhereTheFirstColorClips) {
  const Image balanced =
      white_balanced(mosaic_of(4, 4, "RGGB", [](int, int, int) { return 1.0f; }), "RGGB", {2, 1, 1.5});
  for (const float value : balanced.data) EXPECT_EQ(value, 1.0f);  // white stays white
  const Image dim = white_balanced(mosaic_of(4, 4, "GRBG", [](int, int, int) { return 0.25f; }), "GRBG", {2, 1, 1.5});
  EXPECT_EQ(dim.at(0, 0), 0.25f);
  EXPECT_EQ(dim.at(1, 0), 0.5f);
  EXPECT_EQ(dim.at(0, 1), 0.375f);
}

TEST(Demosaic, ColorsGoThroughTheMatrixOfTheCapture) {
  Image rgb(2, 1, 3);
  rgb.data = {1, 1, 1, 0.5f, 0.25f, 0};
  EXPECT_EQ(in_srgb(rgb, std::nullopt).data, rgb.data);
  const Image out = in_srgb(rgb, Matrix3{1.5, -0.5, 0, 0, 1, 0, -0.25, -0.25, 1.5});
  const std::vector<float> expected = {1, 1, 1, 0.625f, 0.25f, -0.1875f};
  EXPECT_EQ(out.data, expected);
  const Matrix3 m = {1.5, -0.4, -0.1, -0.2, 1.4, -0.2, 0, -0.5, 1.5}, back = inverse(inverse(m));
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(back[i], m[i], 1e-12);
}

}  // namespace
}  // namespace dualpixel
