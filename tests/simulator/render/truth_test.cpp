#include "simulator/render/truth.h"

#include <gtest/gtest.h>

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
