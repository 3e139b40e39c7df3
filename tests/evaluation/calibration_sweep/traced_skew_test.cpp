#include "evaluation/calibration_sweep/traced_skew.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "capture/image/resample.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/calibration_sweep/calibration_target.h"
#include "evaluation/calibration_sweep/plane_disparity.h"
#include "evaluation/methods/disparity_method.h"
#include "tests/evaluation/calibration_sweep/camera_with.h"

namespace dualpixel::evaluation {
namespace {

// Rays against the closed form. Two powers of d leave a sixth of what they describe (KernelSkew.GivesTheShiftOfWaves),
// on either side; 2048 rays err by less.
TEST(TracedSkew, OfAThinLensIsItsSplits) {
  const simulator::Simulation simulation = camera_with("phone_thin_4.4mm_f1.8", 1344, 1008);
  const simulator::LensSampler lens = focused_lens(simulation, 0.6);
  const pipeline::SkewField traced = trace_skew(lens, 2);
  ASSERT_EQ(traced.nodes.size(), 1u);
  const pipeline::SkewCurve split = pipeline::skew_of_split(1 / (4 * 1.19), 2);
  EXPECT_NEAR(traced.nodes[0].farthest_dp_px, split.farthest_dp_px, 1e-6);
  for (const float d : {-1.2f, -0.6f, 0.9f}) {
    const pipeline::KernelSkew a = traced.at(0.5, 0.5).at(d), b = split.at(d);
    EXPECT_NEAR(a.xxx, b.xxx, std::abs(b.xxx) / 3) << d;
    EXPECT_NEAR(a.xyy, b.xyy, std::abs(b.xyy) / 3) << d;
    EXPECT_GT(a.xxx * b.xxx, 0);
    EXPECT_GT(a.xyy * b.xyy, 0);
  }
}

/// Root mean square over the inner 90 % of the field of what the default matcher errs by, in squares of 16 DP px, on a
/// textured plane behind the focus, without noise.
double error_on_plane(const simulator::Simulation& simulation, double focus_m, double plane_m,
                      const pipeline::SkewField& skew) {
  const Camera camera = describe_camera(simulation);
  const simulator::LensSampler lens = focused_lens(simulation, focus_m);
  const int width = camera.dp_width(), height = camera.dp_height();
  const TargetViews views = render_target(make_target_camera(lens, width, height), {plane_m, 0, 1, 8}, 128);
  pipeline::ViewSensor sensor;
  sensor.skew = skew;
  const Image found = method_named(std::string(pipeline::kDefaultMatcher))
                          .run(views.left, views.right, of_camera(sensor, camera))
                          .found.disparity_dp_px;
  const Image wanted = plane_disparity(simulator::DisparityField(lens), camera, plane_m);
  const Image small = resize_area(found, wanted.width, wanted.height);
  double squares = 0, count = 0;
  for (int y = wanted.height / 20; y < wanted.height - wanted.height / 20; ++y) {
    for (int x = wanted.width / 20; x < wanted.width - wanted.width / 20; ++x) {
      squares += std::pow(small.at(x, y) - wanted.at(x, y), 2);
      ++count;
    }
  }
  return std::sqrt(squares / count);
}

// Seven elements: an ideal split's skew is not theirs. What is left is the matcher's and the rendering's noise.
TEST(SlowTracedSkew, TakesAPrescriptionsKernelsOutOfTheMatch) {
  for (const char* lens : {"phone_6p_4.2mm_f1.8", "phone_7p_4.9mm_f1.85"}) {
    simulator::Simulation simulation = camera_with(lens, 1344, 1008);
    const double focus_m = 0.25, plane_m = 1.8;
    simulation.lens = focused_lens(simulation, focus_m).lens();
    const double pixel_height =
        static_cast<double>(simulation.sensor.dp_downsample_y) / simulation.sensor.dp_downsample_x;
    const pipeline::SkewField none{1, 1, std::vector<pipeline::SkewCurve>(1)};
    const double as_shift = error_on_plane(simulation, focus_m, plane_m, none);
    const double ideal = error_on_plane(simulation, focus_m, plane_m, {});
    const double traced =
        error_on_plane(simulation, focus_m, plane_m, trace_skew(focused_lens(simulation, focus_m), pixel_height));
    std::printf("%s: RMS error as shifts %.4f, with an ideal split's skew %.4f, with its own %.4f DP px\n", lens,
                as_shift, ideal, traced);
    EXPECT_LT(traced, 0.5 * as_shift);
    EXPECT_LT(traced, 0.8 * ideal);
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
