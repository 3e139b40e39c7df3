#include "simulator/render/pixel.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>

#include "simulator/sampling/hash.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

// Before a wall that glows evenly both views are alike whatever the number of samples: the odd one of an odd number
// must not favor a half of the pupil. Three standard errors of the photosites' own scatter.
TEST(RenderPixel, SharesOddSamplesBetweenTheHalvesOfThePupil) {
  Scene scene;
  scene.materials = {glowing(100)};
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0)};
  const RenderScene world(scene);
  constexpr int kSide = 64;
  const CameraView camera = phone_camera(1, kSide, kSide);
  for (const Sampling sampling : {Sampling::mirrored, Sampling::joint}) {
    for (const int samples : {1, 2, 3, 5, 17}) {
      RenderOptions options{samples, 0, 5};
      options.sampling = sampling;
      const Views views = render_views(world, camera, options);
      double sum = 0, sum2 = 0, light = 0;
      constexpr int kCount = kSide * kSide;
      for (int i = 0; i < kCount; ++i) {
        const double difference = views.left.data[3 * i] - views.right.data[3 * i];
        sum += difference, sum2 += difference * difference;
        light += views.left.data[3 * i] + views.right.data[3 * i];
      }
      const double mean = sum / kCount, error = std::sqrt((sum2 / kCount - mean * mean) / kCount);
      EXPECT_LE(std::abs(mean), 3 * error + 1e-3) << samples;  // of pairs nothing is left but rounding
      EXPECT_NEAR(light / kCount, 100, 0.01) << samples;
    }
  }
}

// Camera rays need no random numbers but those of their own photosite: before glowing things both ways see the same.
TEST(RenderPixel, SeesTheSameInAPacketThatTwoPhotositesShare) {
  Scene scene;
  scene.materials = {glowing(100), glowing(900)};
  scene.meshes = {make_quad({-5, -5, 3}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({-0.01f, -0.5f, 0.5f}, {0.01f, 0, 0}, {0.005f, 1, 0}, 1)};
  const RenderScene world(scene);
  const CameraView camera = phone_camera(1, 16, 4);
  for (const std::optional<double> ideal : {std::optional<double>(), std::optional<double>(5)}) {
    const PathOptions options{0, ideal};
    for (std::uint32_t samples = 1; samples <= kMostSharedSamples; ++samples) {
      for (int x = 0; x < 16; x += 2) {
        const std::array<std::uint64_t, 2> keys{hash(x, samples), hash(x + 1, samples)};
        const auto pair = render_pixel_pair(world, camera, options, x, 2, samples, keys);
        for (int k = 0; k < 2; ++k) {
          const HalfRadiance alone = render_pixel(world, camera, options, x + k, 2, samples, keys[k]);
          for (int c = 0; c < 3; ++c) {
            EXPECT_FLOAT_EQ(pair[k].left[c], alone.left[c]) << x + k << ", " << samples << " samples";
            EXPECT_FLOAT_EQ(pair[k].right[c], alone.right[c]) << x + k << ", " << samples << " samples";
          }
        }
      }
    }
  }
}

// Reflected light differs from path to path: its mean is that of packets of their own, and what two photosites of a
// packet see is no more alike than chance allows (they share a net, so it may differ more). Of 1024 pairs a correlation
// has a standard error of 1/32; four of each.
TEST(RenderPixel, TakesSixteenDifferentPathsInAPacketThatTwoPhotositesShare) {
  Scene scene;
  scene.materials = {diffuse(0.8f)};
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({-5, -1, 0.2f}, {10, 0, 0}, {0, 0, 0.8f}, 0)};
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(900)}};
  const RenderScene world(scene, {.light_spacing_px = 0});
  const CameraView camera = phone_camera(1, 2, 2);
  const PathOptions options{2};
  constexpr int kPairs = 1024;
  const auto light_of = [](const HalfRadiance& r) { return static_cast<double>(r.left.y) + r.right.y; };
  for (const std::uint32_t samples : {3u, 8u}) {
    double sum = 0, squares = 0, products = 0, alone = 0, alone_squares = 0;
    for (int i = 0; i < kPairs; ++i) {
      const std::array<std::uint64_t, 2> keys{hash(2 * i, samples), hash(2 * i + 1, samples)};
      const auto pair = render_pixel_pair(world, camera, options, 0, 0, samples, keys);
      const double a = light_of(pair[0]), b = light_of(pair[1]);
      sum += a + b, squares += a * a + b * b, products += a * b;
      for (int k = 0; k < 2; ++k) {
        const double own = light_of(render_pixel(world, camera, options, k, 0, samples, hash(keys[k])));
        alone += own, alone_squares += own * own;
      }
    }
    constexpr double kCount = 2.0 * kPairs;
    const double mean = sum / kCount, variance = squares / kCount - mean * mean;
    const double mean_alone = alone / kCount, variance_alone = alone_squares / kCount - mean_alone * mean_alone;
    const double covariance = products / kPairs - mean * mean;
    EXPECT_LT(covariance / variance, 4.0 / 32) << samples;
    const double error2 = (variance + std::max(covariance, 0.0) + variance_alone) / kCount;
    EXPECT_NEAR(mean, mean_alone, 4 * std::sqrt(error2)) << samples;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
