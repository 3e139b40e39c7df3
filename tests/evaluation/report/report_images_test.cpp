#include "evaluation/report/report_images.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/image/image_io.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

TEST(Resized, AveragesAreas) {
  Image image(4, 2);
  image.data = {1, 2, 3, 4, 5, 6, 7, 8};
  EXPECT_EQ(resized(image, 2, 1).data, (std::vector<float>{3.5f, 5.5f}));
  // Three pixels over four: the middle one takes 2/3 of columns 1 and 2 each.
  const Image three = resized(image, 3, 2);
  EXPECT_NEAR(three.at(0, 0), (1 + 2 / 3.0) / (4 / 3.0), 1e-6);  // all of 1, a third of 2
  EXPECT_NEAR(three.at(1, 0), 2.5, 1e-6);
  // Twice as many rows repeat each.
  const Image tall = resized(image, 4, 4);
  EXPECT_EQ(tall.at(2, 0), 3);
  EXPECT_EQ(tall.at(2, 1), 3);
  EXPECT_EQ(tall.at(2, 2), 7);
}

TEST(Resized, LeavesOutWhatIsNotFinite) {
  Image image(4, 1);
  image.data = {NAN, 2, NAN, INFINITY};
  const Image half = resized(image, 2, 1);
  EXPECT_EQ(half.at(0, 0), 2);
  EXPECT_TRUE(std::isnan(half.at(1, 0)));
}

TEST(DivergingColors, AreEquallyLightOnBothSides) {
  Image values(5, 1);
  values.data = {-9, -0.5f, 0, 0.5f, NAN};
  const Image colors = diverging_colors(values, 1);
  // Lightness of Oklab from sRGB; forward matrices of Ottosson 2020.
  const auto lightness = [&](int x) {
    const float r = linear_from_srgb(colors.at(x, 0, 0)), g = linear_from_srgb(colors.at(x, 0, 1)),
                b = linear_from_srgb(colors.at(x, 0, 2));
    return 0.2104542553f * std::cbrt(0.4122214708f * r + 0.5363325363f * g + 0.0514459929f * b) +
           0.7936177850f * std::cbrt(0.2119034982f * r + 0.6806995451f * g + 0.1073969566f * b) -
           0.0040720468f * std::cbrt(0.0883024619f * r + 0.2817188376f * g + 0.6299787005f * b);
  };
  EXPECT_NEAR(lightness(0), 0.48, 0.002);  // beyond the limit the limit's color
  EXPECT_NEAR(lightness(1), 0.72, 0.002);
  EXPECT_NEAR(lightness(2), 0.96, 0.002);
  EXPECT_NEAR(lightness(3), 0.72, 0.002);
  EXPECT_GT(colors.at(1, 0, 2), colors.at(1, 0, 0));  // blue in front
  EXPECT_GT(colors.at(3, 0, 0), colors.at(3, 0, 2));  // orange behind
  EXPECT_EQ(colors.at(4, 0, 0), 0.5f);
}

TEST(Percentile, OfFiniteValues) {
  Image image(6, 1);
  image.data = {5, NAN, 1, 4, 2, 3};
  EXPECT_EQ(percentile(image, 0.5), 3);
  EXPECT_EQ(percentile(image, 1), 5);
  EXPECT_EQ(percentile(Image(2, 1, 1, NAN), 0.5), 0);
}

TEST(JpegDataUri, DecodesToThePicture) {
  Image image(33, 17, 3);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 33; ++x) {
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = (x + y) / 50.0f;
    }
  }
  const std::string uri = jpeg_data_uri(image, 95);
  const std::string head = "data:image/jpeg;base64,";
  ASSERT_TRUE(uri.starts_with(head));
  // Decode base64, four digits at a time.
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  ASSERT_EQ((uri.size() - head.size()) % 4, 0u);
  for (std::size_t i = head.size(); i < uri.size(); i += 4) {
    unsigned group = 0;
    int padding = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t digit = digits.find(uri[i + k]);
      padding += digit == std::string::npos;
      group = group << 6 | (digit == std::string::npos ? 0u : static_cast<unsigned>(digit));
    }
    for (int k = 0; k < 3 - padding; ++k) bytes += static_cast<char>(group >> (16 - 8 * k) & 255);
  }
  const TemporaryFolder folder;
  write_bytes(folder / "decoded.jpg", bytes);
  const Image decoded = read_image(folder / "decoded.jpg");
  ASSERT_TRUE(decoded.same_size(image));
  for (std::size_t i = 0; i < image.data.size(); ++i) ASSERT_NEAR(decoded.data[i], image.data[i], 4.0 / 255);
}

}  // namespace
}  // namespace dualpixel::evaluation
