// Moments of a point's two pictures against the closed forms of the thin lens and of coma.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "evaluation/camera_fit/camera_figures.h"
#include "simulator/lens/lens_sampler.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kRays = 65536;

simulator::Lens thin_lens() {
  simulator::Lens lens;
  lens.thin = {4.442e-3, 1.8, 1.0};
  return lens;
}

PointFigures traced(const simulator::Lens& lens, double depth_m, double x_m = 0) {
  const simulator::SensorGrid sensor{1, 1, 1.4e-6, {0.5 - x_m / 1.4e-6, 0.5}};
  return trace_point(simulator::LensSampler(lens, sensor), 0, 0, depth_m, kRays);
}

// Behind the ramp (1 + p/k)/2 the right view's density over the disc is (1 + p/k)/pi. Its moments are E p = 1/(4k),
// E p^2 = 1/4, E p^3 = 1/(8k); along y E q^2 = 1/4. A point at D lies at -b p / 2. Of 65536 rays of a net, which err
// less than independent ones: three standard errors of a mean of values within the radius are 3 * 0.5 / 256.
TEST(CameraFigures, OfAThinLensBehindARamp) {
  const simulator::Lens lens = thin_lens();
  const double k = lens.split.k, mean = 1 / (4 * k), variance = 0.25 - mean * mean;
  const double third = 1 / (8 * k) - 3 * mean * variance - mean * mean * mean;
  for (const double depth_m : {0.4, 3.0, std::numeric_limits<double>::infinity()}) {
    const double radius_m = 0.5 * lens.thin.blur_diameter_m(depth_m), error = 3 * 0.5 / 256;
    const PointFigures f = traced(lens, depth_m);
    EXPECT_NEAR((f.right.centroid_m.x - f.left.centroid_m.x) / radius_m, 2 * mean, 2 * error);
    EXPECT_GT((f.right.centroid_m.x - f.left.centroid_m.x) * (depth_m - 1), 0);  // nearer than the focus: negative
    for (const BlurKernel* view : {&f.left, &f.right}) {
      EXPECT_NEAR(view->light, 0.5, error);
      EXPECT_NEAR(view->sigma_m.x / std::abs(radius_m), std::sqrt(variance), error);
      EXPECT_NEAR(view->sigma_m.y / std::abs(radius_m), 0.5, error);
      const double side = (view == &f.right ? 1 : -1) * (radius_m > 0 ? 1 : -1);
      EXPECT_NEAR(view->skew_x, side * third / std::pow(variance, 1.5), 6 * error);
    }
    EXPECT_NEAR(f.sum_sigma_m.x / std::abs(radius_m), 0.5, error);
    EXPECT_NEAR(f.sum_sigma_m.y / std::abs(radius_m), 0.5, error);
  }
}

// C (3 p_t^2 + p_s^2, 2 p_t p_s) with p over the disc: means C and 0, variances C^2/2 and C^2/6 on top of the blur's,
// with which they have no moment in common.
TEST(CameraFigures, OfComa) {
  simulator::Lens lens = thin_lens();
  auto& aberrations = lens.model.emplace<simulator::Aberrations>();
  aberrations.coma_um = {3, 5};
  const double h = 0.5, coma_m = 1e-6 * (3 * h + 5 * h * h * h), depth_m = 1.05;
  const double x_m = h * simulator::field_radius_m(aberrations.image_radius_mm, lens.thin);
  const double blur_m = lens.thin.blur_diameter_m(depth_m), error_m = 3 * coma_m / 256;
  const PointFigures f = traced(lens, depth_m, x_m);
  // the photosite's gathering is mirrored in the point's spreading
  EXPECT_NEAR(0.5 * (f.left.centroid_m.x + f.right.centroid_m.x), coma_m, error_m);
  EXPECT_NEAR(0.5 * (f.left.centroid_m.y + f.right.centroid_m.y), 0, error_m);
  EXPECT_NEAR(f.sum_sigma_m.x, std::sqrt(blur_m * blur_m / 16 + coma_m * coma_m / 2), error_m);
  EXPECT_NEAR(f.sum_sigma_m.y, std::sqrt(blur_m * blur_m / 16 + coma_m * coma_m / 6), error_m);
  EXPECT_NEAR(traced(lens, depth_m, -x_m).left.centroid_m.x, -f.right.centroid_m.x, error_m);
}

}  // namespace
}  // namespace dualpixel::evaluation
