#include "simulator/render/pixel.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace dualpixel::simulator::testing
