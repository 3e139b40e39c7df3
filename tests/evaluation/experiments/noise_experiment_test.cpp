#include "evaluation/experiments/noise_experiment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/disparity/matchers.h"

namespace dualpixel::evaluation {
namespace {

// An eighth of the area and a few points: 19 x 13 whole tiles, a deviation has a standard error of about 5 %; over
// depth a quarter of that and 11 %, where a target out of focus is blurred by 2.5 to 6 DP px.
TEST(SlowExperimentNoise, SixFramesAreLessNoisyAndLightHelps) {
  NoiseExperimentOptions options;
  options.width_px = 336;
  options.height_px = 504;
  options.samples_per_pixel = 64;
  options.light_lux = {5, 100};
  options.focus_distances_m = options.depths_m = {0.5, 0.95, 2.4};
  options.depth_samples_per_pixel = 32;
  double last = 0;
  const NoiseExperiment measured = measure_noise(options, [&](double fraction) { last = fraction; });
  EXPECT_NEAR(last, 1, 1e-9);
  ASSERT_EQ(measured.light.size(), 2 * pipeline::matchers().size());  // without and with fixed pattern
  for (const LightSweep& sweep : measured.light) {
    const LightPoint &dim = sweep.points[0], &bright = sweep.points[1];
    EXPECT_GT(dim.one.sigma / dim.six.sigma, 1.5);
    EXPECT_GT(dim.one.robust, bright.one.robust);
    EXPECT_GE(bright.one.robust, 0.9 * bright.six.robust);
  }
  // the likelihood matcher's temporal noise is proportional to the views', which merging reduces to 0.432 (merge.h)
  const LightPoint& point = measured.light[1].points[1];
  EXPECT_NEAR(point.six.temporal / point.one.temporal, 0.432, 4 * 0.432 * 0.07);
  // Fig. S3b: at each depth, depth noise is least with the focus there; with each focus, disparity noise is least at
  // the depth in focus.
  const std::size_t matchers = pipeline::matchers().size();
  ASSERT_EQ(measured.depth.size(), 3 * matchers);
  for (std::size_t in_focus = 0; in_focus < 3; ++in_focus) {
    for (std::size_t matcher = 0; matcher < matchers; ++matcher) {
      const DepthSweep& sweep = measured.depth[in_focus * matchers + matcher];
      for (std::size_t other = 0; other < 3; ++other) {
        if (other == in_focus) continue;
        const DepthSweep& refocused = measured.depth[other * matchers + matcher];
        EXPECT_LT(sweep.points[in_focus].depth_sigma_m, refocused.points[in_focus].depth_sigma_m) << sweep.matcher;
        EXPECT_LT(sweep.points[in_focus].sigma_dp_px, sweep.points[other].sigma_dp_px) << sweep.matcher;
      }
    }
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
