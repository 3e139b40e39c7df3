#include "simulator/sensor/hand_shake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "capture/error.h"
#include "simulator/sensor/motion.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// Small turns about x, y, z and the shift along them.
std::array<double, 6> coordinates(const glm::dmat4& pose) {
  return {pose[1][2], pose[2][0], pose[0][1], pose[3][0], pose[3][1], pose[3][2]};
}

TEST(HandShake, StartsAtTheIdentityAndDependsOnItsArgumentsAlone) {
  EXPECT_EQ(hand_shake(7, 0, 1), glm::dmat4(1));
  EXPECT_EQ(hand_shake(7, 0.3, 0), glm::dmat4(1));
  EXPECT_EQ(hand_shake(7, 0.3, 1), hand_shake(7, 0.3, 1));
  EXPECT_NE(hand_shake(7, 0.3, 1), hand_shake(8, 0.3, 1));
  const glm::dmat4 pose = hand_shake(7, 0.3, 1);
  const glm::dmat4 product = glm::dmat4(glm::dmat3(pose)) * glm::transpose(glm::dmat4(glm::dmat3(pose)));
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(product[i][j], i == j, 1e-12);
  }
}

// Over 3000 paths: each of the six is Gaussian, so a mean square has a standard error of sqrt(2/3000) = 2.6 %; the
// tolerance is four of these. The displacement between two times far apart has twice the variance of the path.
TEST(HandShake, HasTheSpeedAndReachOfItsHeader) {
  constexpr int kPaths = 3000;
  std::array<double, 6> speed2{}, reach2{};
  for (int i = 0; i < kPaths; ++i) {
    const auto a = coordinates(hand_shake(i, 1e-3, 1)), far = coordinates(hand_shake(i, 40, 1));
    for (int k = 0; k < 6; ++k) {
      speed2[k] += a[k] * a[k] / 1e-6 / kPaths;
      reach2[k] += far[k] * far[k] / 2 / kPaths;
    }
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(speed2[k] / (0.015 * 0.015), 1, 4 * 0.026) << k;
    EXPECT_NEAR(reach2[3 + k] / (2e-4 * 2e-4), 1, 4 * 0.026) << k;
  }
}

// Even power over 0.5 .. 12 Hz: the mean square displacement after t is the integral of 2 (1 - cos wt) / w^2.
TEST(HandShake, HasAnEvenSpectrumOfSpeed) {
  constexpr int kPaths = 3000;
  for (const double time_s : {0.02, 0.05, 0.2}) {
    double expected = 0, measured = 0;
    for (int i = 0; i < 1000; ++i) {
      const double omega = 2 * M_PI * (0.5 + 11.5 * (i + 0.5) / 1000);
      expected += 2 * (1 - std::cos(omega * time_s)) / (omega * omega) / 1000 * 0.015 * 0.015;
    }
    for (int i = 0; i < kPaths; ++i) {
      const auto moved = coordinates(hand_shake(i, time_s, 1));
      for (int k = 0; k < 3; ++k) measured += moved[k] * moved[k] / (3 * kPaths);
    }
    EXPECT_NEAR(measured / expected, 1, 4 * 0.026 / std::sqrt(3)) << time_s;
  }
}

/// A wall across the whole view, facing a camera at the origin that looks along +z.
Scene wall(float depth_m) {
  Scene scene;
  scene.materials = {glowing(100)};
  scene.meshes = {make_quad({-9, -9, depth_m}, {18, 0, 0}, {0, 18, 0}, 0)};
  return scene;
}

CameraView moved(CameraView camera, const glm::dmat4& pose) {
  camera.world_from_camera = glm::mat4(pose);
  return camera;
}

// A turn moves every point alike, whatever its depth: the pinhole's homography.
TEST(TraceMotion, IsTheHomographyOfATurn) {
  const CameraView first = phone_camera(1, 96, 64, {}, 14e-6);
  const double turn_rad = 0.01, focal_px = thin(first).image_distance_m() / 14e-6;
  const CameraView later = moved(first, glm::rotate(glm::dmat4(1), turn_rad, glm::dvec3(0, 1, 0)));
  for (const float depth_m : {0.5f, -1.0f}) {  // behind the camera: nothing is hit
    const Scene scene = wall(depth_m);
    const Image motion = trace_motion(RenderScene(scene), first, scene, later);
    for (int y = 0; y < 64; y += 7) {
      for (int x = 0; x < 96; x += 7) {
        const double u = (x + 0.5 - 48) / focal_px, v = (y + 0.5 - 32) / focal_px;
        const double z = std::sin(turn_rad) * u + std::cos(turn_rad);
        const double to_x = focal_px * (std::cos(turn_rad) * u - std::sin(turn_rad)) / z, to_y = focal_px * v / z;
        EXPECT_NEAR(motion.at(x, y, 0), to_x - (x + 0.5 - 48), 2e-3);
        EXPECT_NEAR(motion.at(x, y, 1), to_y - (y + 0.5 - 32), 2e-3);
      }
    }
  }
}

TEST(TraceMotion, IsTheParallaxOfAShiftBeforeAPlane) {
  const CameraView first = phone_camera(1, 96, 64, {}, 14e-6);
  const double focal_px = thin(first).image_distance_m() / 14e-6, depth_m = 0.5;
  const glm::dvec3 shift_m(3e-3, -2e-3, 5e-3);
  const CameraView later = moved(first, glm::translate(glm::dmat4(1), shift_m));
  const Scene scene = wall(0.5f);
  const Image motion = trace_motion(RenderScene(scene), first, scene, later);
  Scene shifted = scene;  // the wall moves the other way: the same picture
  for (glm::vec3& position : shifted.meshes[0].positions) position -= glm::vec3(shift_m);
  const Image of_object = trace_motion(RenderScene(scene), first, shifted, first);
  for (int y = 0; y < 64; y += 7) {
    for (int x = 0; x < 96; x += 7) {
      const double u = x + 0.5 - 48, v = y + 0.5 - 32, z = depth_m - shift_m.z;
      EXPECT_NEAR(motion.at(x, y, 0), (u * depth_m - focal_px * shift_m.x) / z - u, 2e-3);
      EXPECT_NEAR(motion.at(x, y, 1), (v * depth_m - focal_px * shift_m.y) / z - v, 2e-3);
      EXPECT_NEAR(of_object.at(x, y, 0), motion.at(x, y, 0), 2e-3);
      EXPECT_NEAR(of_object.at(x, y, 1), motion.at(x, y, 1), 2e-3);
    }
  }
}

TEST(TraceMotion, IsInfiniteBehindTheCameraAndRefusesOtherTriangles) {
  const CameraView first = phone_camera(1, 16, 16);
  const Scene scene = wall(0.5f);
  const CameraView beyond = moved(first, glm::translate(glm::dmat4(1), glm::dvec3(0, 0, 0.6)));
  const Image motion = trace_motion(RenderScene(scene), first, scene, beyond);
  for (const float value : motion.data) EXPECT_EQ(value, INFINITY);
  Scene fewer = scene;
  fewer.meshes[0].triangles.pop_back();
  EXPECT_THROW(trace_motion(RenderScene(scene), first, fewer, first), InputError);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
