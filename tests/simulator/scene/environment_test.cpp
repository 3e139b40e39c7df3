#include "simulator/scene/environment.h"
#include "simulator/scene/scene.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "capture/image/image_io.h"
#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {
namespace {

float luminance(glm::vec3 rgb) { return glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

std::string write_picture(const TemporaryFolder& folder, const std::string& name, const Image& image) {
  std::string path = (folder.path / name).string();
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path);
  const OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::FLOAT);
  EXPECT_TRUE(output->open(path, spec) && output->write_image(OIIO::TypeDesc::FLOAT, image.data.data()) &&
              output->close());
  return path;
}

TEST(ReadEnvironment, ExrTimesNitsPerUnit) {
  const TemporaryFolder folder;
  Image image(4, 2, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i) / 4;
  const Environment environment = read_environment(write_picture(folder, "sky.exr", image), 100);
  EXPECT_EQ(environment.width, 4);
  EXPECT_EQ(environment.height, 2);
  ASSERT_EQ(environment.radiance_nits.size(), 8u);
  EXPECT_EQ(environment.radiance_nits[0], glm::vec3(0, 25, 50));
  EXPECT_EQ(environment.radiance_nits[5], glm::vec3(375, 400, 425));
}

TEST(ReadEnvironment, HdrWithinItsPrecision) {
  const TemporaryFolder folder;
  const Image image(8, 4, 3, 3.0f);
  const Environment environment = read_environment(write_picture(folder, "sky.hdr", image), 2);
  // RGBE holds 8 bits of the largest component.
  for (const glm::vec3& nits : environment.radiance_nits) EXPECT_NEAR(nits.g, 6, 6.0 / 128);
}

TEST(ReadEnvironment, GrayAndAlpha) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_environment(write_picture(folder, "gray.exr", Image(2, 1, 1, 0.5f)), 2).radiance_nits[1],
            glm::vec3(1));
  EXPECT_EQ(read_environment(write_picture(folder, "rgba.exr", Image(2, 1, 4, 0.5f)), 2).radiance_nits[1],
            glm::vec3(1));
}

TEST(ReadEnvironment, Refusals) {
  const TemporaryFolder folder;
  const auto message = [](const std::string& path) { return refusal([&] { read_environment(path, 1); }); };
  Image image(2, 1, 3, 1.0f);
  const std::string png = write_picture(folder, "sky.png", image);
  EXPECT_EQ(message(png), png + ": is no EXR or HDR picture, as an environment must be");
  image.data[4] = -0.5f;
  const std::string negative = write_picture(folder, "negative.exr", image);
  EXPECT_EQ(message(negative), negative + ": pixel (1, 0) holds -0.5, -0.5 nits: must lie in [0, 1e+12] nits");
  image.data[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(message(write_picture(folder, "nan.exr", image)).find("pixel (1, 0) holds nan"), std::string::npos);
  image.data[4] = 2e12f;
  EXPECT_NE(message(write_picture(folder, "bright.exr", image)).find("must lie in [0, 1e+12] nits"), std::string::npos);
  const std::string wide = write_picture(folder, "wide.exr", Image(16385, 1, 1));
  EXPECT_EQ(message(wide), wide + ": 16385 x 1 pixels: an environment has at most 16384 x 8192");
  const std::string two = write_picture(folder, "two.exr", Image(2, 1, 2));
  EXPECT_EQ(message(two), two + ": 2 channels: an environment has 1 or at least 3 (R, G, B)");
  EXPECT_NE(message((folder.path / "none.exr").string()).find("no such file"), std::string::npos);
}

TEST(Sky, LooksLikeItsOptions) {
  SkyOptions options;
  options.sun_glow_nits = 0;
  const Environment sky = make_sky(options, 512);
  ASSERT_EQ(sky.width, 512);
  ASSERT_EQ(sky.height, 256);
  const auto at = [&](int x, int y) { return sky.radiance_nits[static_cast<std::size_t>(y) * 512 + x]; };
  // Half a row from the zenith: (1 - cos)^4 is nothing.
  EXPECT_NEAR(luminance(at(17, 0)), options.zenith_nits, 1e-3f * options.zenith_nits);
  EXPECT_GT(at(17, 0).b, 2 * at(17, 0).r);
  EXPECT_NEAR(luminance(at(400, 255)), options.ground_nits, 1e-3f * options.ground_nits);
  // Row 124 is 2.46 degrees above the horizon, where haze = (1 - sin 2.46 deg)^4.
  const double haze = std::pow(1 - std::sin(3.5 / 256 * std::numbers::pi), 4);
  EXPECT_NEAR(luminance(at(0, 124)), options.zenith_nits + haze * (options.horizon_nits - options.zenith_nits), 1);
  EXPECT_GT(at(0, 124).r, at(0, 124).b);
}

TEST(Sky, TheGlowStandsWhereTheSunIs) {
  SkyOptions options;
  options.zenith_nits = options.horizon_nits = options.ground_nits = 0;
  options.sun_elevation_deg = 30;
  options.sun_azimuth_deg = 90;                    // +x: three quarters across
  const Environment sky = make_sky(options, 720);  // half a degree a pixel
  std::size_t brightest = 0;
  double irradiance = 0;  // of a sphere around: the integral of luminance over solid angle
  for (std::size_t i = 0; i < sky.radiance_nits.size(); ++i) {
    if (luminance(sky.radiance_nits[i]) > luminance(sky.radiance_nits[brightest])) brightest = i;
    const std::size_t row = i / 720;
    const double elevation = (0.5 - (row + 0.5) / 360) * std::numbers::pi;
    irradiance += luminance(sky.radiance_nits[i]) * std::cos(elevation) * std::pow(std::numbers::pi / 360, 2);
  }
  EXPECT_NEAR(static_cast<double>(brightest % 720), 540, 1);
  const std::size_t brightest_row = brightest / 720;
  EXPECT_NEAR(static_cast<double>(brightest_row), 120, 1);  // (90 - 30) degrees from the top
  EXPECT_NEAR(luminance(sky.radiance_nits[brightest]), options.sun_glow_nits, 0.01f * options.sun_glow_nits);
  // A Gaussian lobe on the sphere: 2 pi peak s^2 (1 - s^2/3 + ...) for the standard deviation s in radians; the tail
  // below the horizon, 2.5 deviations away, is cut off (its weight is under 1 %).
  const double s = options.sun_glow_width_deg * std::numbers::pi / 180;
  EXPECT_NEAR(irradiance / (2 * std::numbers::pi * options.sun_glow_nits * s * s * (1 - s * s / 3)), 1, 0.01);
}

TEST(Sky, IsSmoothAndDeterministic) {
  const Environment sky = make_sky({}, 256);
  EXPECT_EQ(sky.radiance_nits, make_sky({}, 256).radiance_nits);
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const glm::vec3 nits = sky.radiance_nits[static_cast<std::size_t>(y) * 256 + x];
      const glm::vec3 right = sky.radiance_nits[static_cast<std::size_t>(y) * 256 + (x + 1) % 256];
      ASSERT_GT(std::min({nits.r, nits.g, nits.b}), 0);
      // The lobe's steepest slope is 0.61 peak per 12 degrees; a pixel is 1.4 degrees.
      ASSERT_LT(std::abs(luminance(nits) - luminance(right)), 0.61f * 40000 * 1.41f / 12);
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator
