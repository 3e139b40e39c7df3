#include "pipeline/defocus/match_lens.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/error.h"

namespace dualpixel::pipeline {
namespace {

Camera phone() {
  Camera camera;
  camera.width_px = 2688;
  camera.height_px = 2016;
  camera.pixel_pitch_um = 1.4;
  camera.focal_length_mm = 4.442;
  camera.f_number = 1.8;
  camera.focus_distance_m = 0.8;
  camera.alpha = 0.21;
  return camera;
}

/// Signed blur diameter on the sensor behind a pupil, photosites: the thin lens's.
double blur_px(const Camera& camera, double pupil_mm, double depth_m) {
  const double z = camera.focus_distance_m, f_m = camera.focal_length_mm * 1e-3;
  return pupil_mm * 1e-3 * f_m / (1 - f_m / z) * (1 / z - 1 / depth_m) / (camera.pixel_pitch_um * 1e-6);
}

TEST(MatchLens, GivesTheDiscThatTheLensWouldGive) {
  const Camera camera = phone();
  const double own_mm = camera.focal_length_mm / camera.f_number, lens_mm = 12.5;
  const BlurMapping exact = match_lens(camera, lens_mm, 0, true), added = match_lens(camera, lens_mm, 0);
  for (const double depth_m : {0.4, 0.6, 0.8, 1.2, 3.0, 100.0}) {
    const double own_px = blur_px(camera, own_mm, depth_m), wide_px = blur_px(camera, lens_mm, depth_m);
    const auto disparity = static_cast<float>(camera.alpha * own_px / camera.dp_downsample_x);
    EXPECT_NEAR(exact.radius_px(disparity), std::abs(wide_px) / 2, 1e-4) << depth_m;
    // discs' variances add up
    EXPECT_NEAR(std::pow(added.radius_px(disparity), 2) + own_px * own_px / 4, wide_px * wide_px / 4, 1e-3) << depth_m;
  }
}

// Disparity is linear in 1/D, so that a lens focused elsewhere differs by an offset (and by f/z in its scale).
TEST(MatchLens, RefocusesByAnOffset) {
  const Camera camera = phone();
  const BlurMapping mapping = match_lens(camera, 12.5, 0.25, true);
  EXPECT_EQ(mapping.radius_px(0.25f), 0);
  EXPECT_NEAR(mapping.radius_px(0.75f), mapping.radius_px(-0.25f), 1e-4);
  EXPECT_NEAR(mapping.radius_px(0.75f), match_lens(camera, 12.5, 0, true).radius_px(0.5f), 1e-4);
}

TEST(MatchLens, NeverNarrowsAndIsCapped) {
  const Camera camera = phone();
  EXPECT_EQ(match_lens(camera, 1, 0).radius_px(3), 0);
  EXPECT_EQ(match_lens(camera, 2000, 0).radius_px(3), 2688 / 8);
}

TEST(MatchLens, NeedsToKnowTheCamera) {
  for (double Camera::*field : {&Camera::alpha, &Camera::focal_length_mm, &Camera::f_number}) {
    for (const double value : {0.0, -1.0, std::nan("")}) {
      Camera camera = phone();
      camera.*field = value;
      EXPECT_THROW(match_lens(camera, 12.5, 0), InputError);
    }
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
