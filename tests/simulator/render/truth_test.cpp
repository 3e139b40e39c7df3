#include "simulator/render/truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

// A slanted plane z = 1 + 0.5 x: the pinhole ray with slope t = x/z meets it at the planar depth 1 / (1 - 0.5 t).
TEST(Truth, PlanarDepthBlurAndDisparityOfASlantedPlane) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-1, -1, 0.5f}, {2, 0, 1}, {0, 2, 0}, 0)};
  scene.meshes[0].object_id = 7;
  scene.meshes[0].person = true;
  const CameraView camera = phone_camera(0.9, 64, 32, {}, 20e-6);  // a wide field on few pixels
  const Truth truth = trace_truth(RenderScene(scene), camera);
  for (int y = 0; y < 32; y += 5) {
    for (int x = 0; x < 64; x += 7) {
      const double slope = (x + 0.5 - 32) * 20e-6 / thin(camera).image_distance_m();
      const double depth = 1 / (1 - 0.5 * slope);
      EXPECT_NEAR(truth.depth_m.at(x, y), depth, 2e-6);
      const double f = 4.442e-3, z = 0.9;
      const double blur = f / 1.8 * f / (1 - f / z) * (1 / z - 1 / depth);
      EXPECT_NEAR(truth.blur_px.at(x, y), blur / 20e-6, 1e-4);
      EXPECT_NEAR(truth.disparity_dp_px.at(x, y), blur / 40e-6 / (4 * 1.19), 1e-5);
      EXPECT_EQ(truth.object_id.at(x, y), 7u);
      EXPECT_EQ(truth.person_mask.at(x, y), 1);
      const double norm = std::sqrt(1.25);
      EXPECT_NEAR(truth.normal.at(x, y, 0), 0.5 / norm, 1e-5);
      EXPECT_NEAR(truth.normal.at(x, y, 2), -1 / norm, 1e-5);
    }
  }
}

// A person whose left outline crosses the picture at u = u0 + k v photosites: each photosite holds the area on its
// right. Sixteen rays are off by some hundredths, and by nothing on average.
TEST(Truth, PersonMaskIsTheShareOfEachPhotosite) {
  constexpr int kSide = 48;
  constexpr double kStart = 17.3, kSlope = 0.21, kFine = 64;
  const CameraView camera = phone_camera(1, kSide, kSide);
  const double photosite_m = 1.4e-6 / thin(camera).image_distance_m();  // at 1 m
  const auto edge = [&](double v) { return static_cast<float>((kStart + kSlope * v - kSide / 2.0) * photosite_m); };
  const auto down = [&](double v) { return static_cast<float>((v - kSide / 2.0) * photosite_m); };
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  const glm::vec3 corner(edge(-kSide), down(-kSide), 1);
  scene.meshes = {make_quad(corner, {1, 0, 0}, {edge(2 * kSide) - corner.x, down(2 * kSide) - corner.y, 0}, 0)};
  scene.meshes[0].person = true;
  const Truth truth = trace_truth(RenderScene(scene), camera);
  double sum = 0, worst = 0;
  int mixed = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double covered = 0;
      for (int i = 0; i < kFine; ++i) {
        covered += std::clamp(x + 1 - (kStart + kSlope * (y + (i + 0.5) / kFine)), 0.0, 1.0) / kFine;
      }
      const double off = truth.person_mask.at(x, y) - covered;
      if (covered == 0 || covered == 1) {
        EXPECT_EQ(off, 0) << x << ' ' << y;
      }
      mixed += covered > 0 && covered < 1 ? 1 : 0;
      sum += off;
      worst = std::max(worst, std::abs(off));
    }
  }
  EXPECT_GT(mixed, kSide);
  EXPECT_LT(worst, 0.1);
  EXPECT_NEAR(sum / mixed, 0, 0.01);
}

// Bands of rows are traced one by one where the shutter rolls past animated things: an outline that lies at their
// border is that of the whole picture.
TEST(Truth, PersonMaskOfBandsIsThatOfTheWholePicture) {
  constexpr int kSide = 48, kBand = 16;
  const CameraView camera = phone_camera(1, kSide, kSide);
  const double photosite_m = 1.4e-6 / thin(camera).image_distance_m();  // at 1 m
  for (const double top : {15.3, 16.4, 31.7}) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {make_quad({-1, static_cast<float>((top - kSide / 2.0) * photosite_m), 1}, {2, 0, 0}, {0, 1, 0}, 0)};
    scene.meshes[0].person = true;
    const RenderScene world(scene);
    Truth bands = empty_truth(camera.lens.sensor());
    for (int row = 0; row < kSide; row += kBand) trace_truth_rows(world, camera, row, row + kBand, bands);
    EXPECT_EQ(bands.person_mask.data, trace_truth(world, camera).person_mask.data) << top;
    EXPECT_NEAR(bands.person_mask.at(5, static_cast<int>(top)), 1 - (top - std::floor(top)), 1.0 / 16) << top;
  }
}

TEST(Truth, NothingHitIsInfinitelyFarAndNotValid) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({5, 5, 1}, {1, 0, 0}, {0, 1, 0}, 0)};
  const CameraView camera = phone_camera(0.9, 8, 8);
  const Truth truth = trace_truth(RenderScene(scene), camera);
  EXPECT_EQ(truth.valid.at(3, 3), 0);
  EXPECT_TRUE(std::isinf(truth.depth_m.at(3, 3)));
  EXPECT_EQ(truth.object_id.at(3, 3), 0u);
  const double far_blur = thin(camera).pupil_diameter_m() * thin(camera).image_distance_m() / 0.9 / 1.4e-6;
  EXPECT_NEAR(truth.blur_px.at(3, 3), far_blur, 1e-4);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
