// The claims that everything else rests on: signed disparity, blur diameter, and energy, against the closed forms of
// the thin lens. Targets are glowing squares; the centroid of a square under a disc is that of a point.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr int kSize = 80;         // pixels of the little sensor
constexpr double kTargetPx = 22;  // the square's side on the sensor

/// A glowing square, centered on the axis at the depth where the signed blur diameter is `blur_px`.
Scene square_with_blur(const CameraView& camera, double blur_px) {
  const ThinLens& lens = thin(camera);
  const double pitch_m = camera.lens.sensor().pixel_pitch_m;
  const double inverse_depth =
      1 / lens.focus_distance_m - blur_px * pitch_m / (lens.pupil_diameter_m() * lens.image_distance_m());
  const double depth = 1 / inverse_depth;
  const auto side = static_cast<float>(kTargetPx * pitch_m / lens.image_distance_m() * depth);
  Scene scene;
  scene.materials = {glowing(100)};
  scene.meshes = {make_quad({-side / 2, -side / 2, static_cast<float>(depth)}, {side, 0, 0}, {0, side, 0}, 0)};
  return scene;
}

Views render_square(const CameraView& camera, double blur_px, int samples = 512) {
  const Scene scene = square_with_blur(camera, blur_px);
  return render_views(RenderScene(scene), camera, {samples, 0, 7});
}

class Splits : public ::testing::TestWithParam<SplitPixel> {};

// Sampling error: each of ~500 pixels on the square's rim averages 512 samples. With independent ones the centroid of
// a view would err by about (b/4) / sqrt(22^2 * 512) = 0.016 px at b = 32 px (0.008 DP px); the stratified net cuts
// that by more than four, so 0.01 DP px leaves over three standard errors.
TEST_P(Splits, CentroidDisparityIsAlphaTimesBlur) {
  const CameraView camera = phone_camera(0.2, kSize, kSize, GetParam());
  for (double blur_dp_px : {-16.0, -9.0, -4.0, -1.0, 0.0, 0.5, 2.0, 6.0, 12.0, 16.0}) {
    const Views views = render_square(camera, 2 * blur_dp_px);
    const double measured_dp_px = (moments(views.right).x - moments(views.left).x) / 2;
    EXPECT_NEAR(measured_dp_px, GetParam().alpha() * blur_dp_px, 0.01) << "blur " << blur_dp_px << " DP px";
  }
}

INSTANTIATE_TEST_SUITE_P(All, Splits,
                         ::testing::Values(SplitPixel{SplitKind::hard, 1}, SplitPixel{SplitKind::ramp, 1},
                                           SplitPixel{SplitKind::ramp, 1.19}));

// A disc of diameter b has variance b^2/16 along each axis; the square adds s^2/12, the pixel's box 1/12.
TEST(ThinLensBlur, DiameterFollowsFromTheSecondMoment) {
  const CameraView camera = phone_camera(0.2, kSize, kSize);
  for (double blur_px : {-32.0, -20.0, -8.0, 8.0, 14.0, 32.0}) {
    const Moments m = moments(undivided(render_square(camera, blur_px)));
    const double sharp = (kTargetPx * kTargetPx + 1) / 12;
    EXPECT_NEAR(4 * std::sqrt(m.variance_x - sharp), std::abs(blur_px), 0.01 * std::abs(blur_px));
    EXPECT_NEAR(4 * std::sqrt(m.variance_y - sharp), std::abs(blur_px), 0.01 * std::abs(blur_px));
  }
}

TEST(ThinLensBlur, NothingMovesOnTheFocusPlane) {
  const CameraView camera = phone_camera(0.2, kSize, kSize);
  const Views views = render_square(camera, 0);
  EXPECT_NEAR(moments(views.right).x, moments(views.left).x, 0.002);
  // 22 whole pixels, sharp to the edge: the variance of 22 equal numbers in a row
  EXPECT_NEAR(moments(undivided(views)).variance_x, (kTargetPx * kTargetPx - 1) / 12, 1e-3);
}

// In front of the focus plane the right view's picture lies to the left of the left view's: right(x + d) = left(x)
// with d < 0. Behind it, the other way round. Swapped views, a mirrored sensor or a mirrored pupil fail here.
TEST(ViewSign, NearIsNegativeAndFarPositive) {
  const CameraView camera = phone_camera(0.2, kSize, kSize);
  const Views near = render_square(camera, -10);
  EXPECT_LT(moments(near.right).x, moments(near.left).x - 1);
  const Views far = render_square(camera, 10);
  EXPECT_GT(moments(far.right).x, moments(far.left).x + 1);
}

// The picture is upright: what lies to the right of the axis (+x) and below it (+y) appears at larger x and y.
TEST(ViewSign, PictureIsUpright) {
  const CameraView camera = phone_camera(0.2, kSize, kSize);
  Scene scene = square_with_blur(camera, 0);
  for (glm::vec3& p : scene.meshes[0].positions) p += glm::vec3(4e-4f, 8e-4f, 0);
  const Moments m = moments(undivided(render_views(RenderScene(scene), camera, {64, 0, 1})));
  const double px_per_m = thin(camera).image_distance_m() / camera.lens.sensor().pixel_pitch_m / 0.2;
  EXPECT_NEAR(m.x - kSize / 2, 4e-4 * px_per_m, 0.02);
  EXPECT_NEAR(m.y - kSize / 2, 8e-4 * px_per_m, 0.02);
}

// The same samples under another split differ only in how each is shared: left + right never changes. A ramp with a
// huge k halves every sample exactly, which is the undivided pixel. Tolerance: one rounding per sum of 64 terms.
TEST(SplitPixel, LeftPlusRightIsTheUndividedPixel) {
  const SplitPixel halving{SplitKind::ramp, 1e6};
  const Image whole = undivided(render_square(phone_camera(0.2, kSize, kSize, halving), 13, 64));
  for (const SplitPixel& split : {SplitPixel{SplitKind::hard, 1}, SplitPixel{SplitKind::ramp, 1},
                                  SplitPixel{SplitKind::ramp, 1.19}, SplitPixel{SplitKind::ramp, 5}}) {
    const Image sum = undivided(render_square(phone_camera(0.2, kSize, kSize, split), 13, 64));
    for (std::size_t i = 0; i < sum.data.size(); ++i) {
      ASSERT_NEAR(sum.data[i], whole.data[i], 64 * 0x1p-23 * 100);
    }
  }
}

// On the axis a glowing wall of L nits fills the lens: every photosite sees exactly L, half of it in each view.
TEST(SplitPixel, AnEvenWallIsSharedInHalves) {
  const CameraView camera = phone_camera(0.5, 16, 16);
  Scene scene;
  scene.materials = {glowing(250)};
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0)};
  const Views views = render_views(RenderScene(scene), camera, {1024, 0, 3});
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      EXPECT_NEAR(views.left.at(x, y) + views.right.at(x, y), 250, 250 * 1e-4);
      EXPECT_NEAR(views.left.at(x, y), 125, 125 * 0.002);
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
