#include "evaluation/experiments/noise_experiment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/disparity/matchers.h"

namespace dualpixel::evaluation {
namespace {

// An eighth of the area and a few points: 19 x 13 whole tiles, a deviation has a standard error of about 5 %.
TEST(SlowExperimentNoise, SixFramesAreLessNoisyAndLightHelps) {
  NoiseExperimentOptions options;
  options.width_px = 336;
  options.height_px = 504;
  options.samples_per_pixel = 64;
  options.light_lux = {5, 100};
  options.focus_distances_m = {0.95};
  options.depths_m = {0.5, 0.95, 2.4};
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
  for (const DepthSweep& sweep : measured.depth) {
    EXPECT_LT(sweep.points[1].sigma_dp_px, sweep.points[0].sigma_dp_px);
    EXPECT_LT(sweep.points[1].sigma_dp_px, sweep.points[2].sigma_dp_px);
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
