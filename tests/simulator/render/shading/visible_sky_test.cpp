#include "simulator/render/shading/visible_sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "simulator/render/shading/lights.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr float kSide = 4, kWindow = 1.6f;  // meters

/// A closed room whose ceiling has a square hole in the middle, under an even sky.
Scene room_with_skylight() {
  const float edge = (kSide - kWindow) / 2;
  Scene scene;
  scene.materials = {diffuse(0)};
  const auto add = [&](glm::vec3 corner, glm::vec3 a, glm::vec3 b) {
    scene.meshes.push_back(make_quad(corner, a, b, 0));
  };
  add({0, 0, 0}, {kSide, 0, 0}, {0, 0, kSide});
  add({0, kSide, 0}, {edge, 0, 0}, {0, 0, kSide});
  add({kSide - edge, kSide, 0}, {edge, 0, 0}, {0, 0, kSide});
  add({edge, kSide, 0}, {kWindow, 0, 0}, {0, 0, edge});
  add({edge, kSide, kSide - edge}, {kWindow, 0, 0}, {0, 0, edge});
  for (const float at : {0.0f, kSide}) {
    add({at, 0, 0}, {0, kSide, 0}, {0, 0, kSide});
    add({0, 0, at}, {kSide, 0, 0}, {0, kSide, 0});
  }
  scene.environment = {2, 1, {glm::vec3(1000), glm::vec3(1000)}};
  return scene;
}

/// Form factor from a point to a parallel rectangle whose corner lies above it (Howell's catalog, B-3).
double corner_form_factor(double a, double b, double height) {
  const double x = a / height, y = b / height, p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
  return (x / p * std::atan(y / p) + y / q * std::atan(x / q)) / (2 * M_PI);
}

/// Of the skylight, from a point of the floor at (x, z) from its middle.
double skylight_form_factor(double x, double z) {
  double sum = 0;
  for (const int side_x : {-1, 1}) {
    for (const int side_z : {-1, 1}) {
      const double a = kWindow / 2 + side_x * x, b = kWindow / 2 + side_z * z;
      sum += std::copysign(1.0, a) * std::copysign(1.0, b) * corner_form_factor(std::abs(a), std::abs(b), kSide);
    }
  }
  return sum;
}

/// Sky light that arrives at a point of the floor, by samples of which `found` met no wall.
double sampled_lux(const Intersector& intersector, const Lights& lights, glm::vec3 point, std::uint64_t key,
                   int samples, int& found) {
  alignas(64) int all[kPacket];
  Vec3Packet points, normals;
  for (int i = 0; i < kPacket; ++i) all[i] = -1, points.set(i, point), normals.set(i, {0, 1, 0});
  double sum = 0;
  for (int first = 0; first < samples; first += kPacket) {
    alignas(64) float numbers[4][kPacket];
    joint_samples(first, key, numbers);
    LightPacket light;
    lights.sample(all, points, normals, numbers[0], numbers[1], light);
    for (int i = 0; i < kPacket; ++i) {
      const glm::vec3 d = light.direction.at(i);
      if (d.y <= 0 || intersector.intersect(Ray{point, d})) continue;
      sum += light.radiance.at(i).y * d.y;
      ++found;
    }
  }
  return sum / samples;
}

// A skylight of 160 cm over a floor 4 m below gives 3 to 5 % of the sky's light. A quarter to a third of the samples
// find it, and their mean is the closed form: to four standard errors of 16 nets' own scatter.
TEST(VisibleSky, SendsSamplesThroughTheWindow) {
  const Scene scene = room_with_skylight();
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  for (const glm::vec2 at : {glm::vec2(0), glm::vec2(0.7f, -0.4f), glm::vec2(1.5f, 1.6f)}) {
    constexpr int kSamples = 1024, kNets = 16;
    int found = 0;
    double sum = 0, squares = 0;
    for (int net = 0; net < kNets; ++net) {
      const glm::vec3 point(kSide / 2 + at.x, 1e-4f, kSide / 2 + at.y);
      const double lux = sampled_lux(intersector, lights, point, net, kSamples, found);
      sum += lux, squares += lux * lux;
    }
    const double mean = sum / kNets, error = std::sqrt((squares / kNets - mean * mean) / (kNets - 1));
    const double wanted = M_PI * 1000 * skylight_form_factor(at.x, at.y);
    EXPECT_NEAR(mean, wanted, 4 * error) << at.x;
    EXPECT_LT(error, 0.01 * wanted) << at.x;
    EXPECT_GT(found, kSamples * kNets / 5) << at.x;
  }
}

// Under an open sky nothing changes, and a cube without surfaces is open.
TEST(VisibleSky, LeavesOpenPlacesAlone) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-5, 0, -5}, {0, 0, 10}, {10, 0, 0}, 0),
                  make_quad({-5, 5, -5}, {0, 0, 0.1f}, {0.1f, 0, 0}, 0)};
  scene.environment = {2, 1, {glm::vec3(1000), glm::vec3(1000)}};
  const Intersector intersector(scene);
  const EnvironmentLight light(scene.environment);
  const VisibleSky sky(light, intersector);
  EXPECT_EQ(sky.from({1, 0, 1}, {0, 1, 0}).share, 0);
  EXPECT_GT(sky.from({1, 0, 1}, {0, 1, 0}).visible, 0.85f);  // its table reaches a few degrees below the horizon
  EXPECT_EQ(sky.from({1, 3, 1}, {0, 1, 0}).visible, 1);

  const Scene room = room_with_skylight();
  const Intersector walls(room);
  const VisibleSky seen(light, walls);
  EXPECT_GT(seen.from({2, 1e-4f, 2}, {0, 1, 0}).share, 0.5f);
  EXPECT_NEAR(seen.from({2, 1e-4f, 2}, {0, 1, 0}).visible, skylight_form_factor(0, 0), 0.02);
}

// The density is that of the samples, and integrates to one, in a room as well (midpoint rule).
TEST(VisibleSky, DensityIsTheSamplers) {
  const Scene scene = room_with_skylight();
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  const glm::vec3 point(1, 1e-4f, 3), normal(0, 1, 0);
  double integral = 0;
  constexpr int kRows = 512;
  for (int i = 0; i < kRows; ++i) {
    const double theta = M_PI * (i + 0.5) / kRows;
    for (int j = 0; j < 2 * kRows; ++j) {
      const double phi = M_PI * (j + 0.5) / kRows;
      const glm::vec3 d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      integral += lights.environment_pdf(point, normal, d) * std::sin(theta) * std::pow(M_PI / kRows, 2);
    }
  }
  EXPECT_NEAR(integral, 1, 1e-3);
  int disagreements = 0;
  constexpr int kSamples = 4096;
  for (int first = 0; first < kSamples; first += kPacket) {
    alignas(64) int all[kPacket];
    Vec3Packet points, normals;
    for (int i = 0; i < kPacket; ++i) all[i] = -1, points.set(i, point), normals.set(i, normal);
    alignas(64) float numbers[4][kPacket];
    joint_samples(first, 3, numbers);
    LightPacket s;
    lights.sample(all, points, normals, numbers[0], numbers[1], s);
    for (int i = 0; i < kPacket; ++i) {  // directions on the border of two cells may round into either
      const float pdf = lights.environment_pdf(point, normal, s.direction.at(i));
      disagreements += std::abs(pdf - s.pdf[i]) > 1e-3f * s.pdf[i];
    }
  }
  EXPECT_LT(disagreements, kSamples / 1000);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
