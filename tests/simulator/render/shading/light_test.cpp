// Light transport against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/render/shading/bsdf.h"
#include "simulator/render/shading/lights.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

Mesh box(float half, int material) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({(i & 1 ? half : -half), (i & 2 ? half : -half), (i & 4 ? half : -half)});
  }
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  mesh.material = material;
  return mesh;
}

double mean(const Image& image) {
  double sum = 0;
  for (float v : image.data) sum += v;
  return sum / static_cast<double>(image.data.size());
}

class Furnace : public ::testing::TestWithParam<float> {};

// Inside a closed diffuse box of albedo rho that glows with e everywhere, radiance is e / (1 - rho) in all directions.
// n bounces leave out rho^(n+2) of it: 60 make that 2e-6 at rho = 0.8.
TEST_P(Furnace, ReturnsTheGeometricSeries) {
  const float albedo = GetParam();
  Scene scene;
  scene.materials = {glowing(10)};
  scene.materials[0].base_color = {albedo, albedo, albedo, 1};
  scene.meshes = {box(1, 0)};
  const Image image = undivided(render_views(RenderScene(scene), phone_camera(0.7, 16, 16), {64, 60, 5}));
  EXPECT_NEAR(mean(image), 10 / (1 - albedo), 0.005 * 10 / (1 - albedo));
}

INSTANTIATE_TEST_SUITE_P(Albedo, Furnace, ::testing::Values(0.0f, 0.3f, 0.5f, 0.8f));

// A diffuse wall under an even sky, no occluder: L = rho * sky. Facing the camera it sees the half space in full.
TEST(DirectLight, EvenSkyOnAWall) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.environment = {2, 1, {glm::vec3(1000), glm::vec3(1000)}};
  const Image image = undivided(render_views(RenderScene(scene), phone_camera(1, 16, 16), {256, 0, 5}));
  EXPECT_NEAR(mean(image), 500, 500 * 0.005);
}

// Directional light of E lux at 60 degrees on albedo rho: L = rho E cos(60) / pi. No randomness in it.
TEST(DirectLight, DirectionalLightFollowsLambert) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0)};
  PunctualLight light;
  light.kind = PunctualLight::Kind::directional;
  light.intensity = glm::vec3(10000);
  light.direction = {std::sin(M_PI / 3), 0, std::cos(M_PI / 3)};
  scene.lights = {light};
  const Image image = undivided(render_views(RenderScene(scene), phone_camera(1, 8, 8), {16, 0, 5}));
  EXPECT_NEAR(mean(image), 0.5 * 10000 * 0.5 / M_PI, 0.01);
}

// A candela source 2 m in front of a wall: E = I / d^2 at the foot of the perpendicular.
TEST(DirectLight, PointLightFollowsInverseSquare) {
  Scene scene;
  scene.materials = {diffuse(1)};
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0)};
  PunctualLight light;
  light.intensity = glm::vec3(80);
  scene.lights = {light};
  const Image image = undivided(render_views(RenderScene(scene), phone_camera(2, 4, 4), {16, 0, 5}));
  EXPECT_NEAR(mean(image), 80.0 / 4 / M_PI, 1e-3);
}

// A lamp that shines on a wall has its share of the samples, however strong another is that a board hides. With two
// lamps, a weak one counts for at least 1 / 200 of the average light, and half of the samples go by that: of 1 048 576,
// 2600 find it, an error of 2 %; four of these.
TEST(DirectLight, AWeakLampIsNotLostBesideAStrongOne) {
  Scene scene;
  scene.materials = {diffuse(1)};
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0), make_quad({1, -1, 1}, {1, 0, 0}, {0, 2, 0}, 0)};
  PunctualLight weak, strong;
  weak.intensity = glm::vec3(80);
  strong.intensity = glm::vec3(1e10);
  strong.position = {3, 0, 0};
  scene.lights = {weak, strong};
  const RenderScene world(scene, {.light_spacing_px = 0});
  EXPECT_NEAR(mean(undivided(render_views(world, phone_camera(2, 16, 16), {4096, 0, 5}))), 80.0 / 4 / M_PI, 0.08 * 6.4);
}

// A glowing square seen from straight below: form factor of a parallel square (side 1 at distance 1) to a small
// facing element, F = 4 * [X/sqrt(1+X^2) atan(Y/sqrt(1+X^2)) + ...] / (2 pi) with X = Y = 1/2 (Howell, B-3).
TEST(DirectLight, AreaLightMatchesItsFormFactor) {
  Scene scene;
  scene.materials = {diffuse(1), glowing(100)};
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({-0.5f, -0.5f, 1}, {1, 0, 0}, {0, 1, 0}, 1)};
  CameraView camera = phone_camera(2, 4, 4);
  // look at the wall from the side, under the light: from x = -1.5 towards the point (0, 0, 2)
  const glm::vec3 forward = glm::normalize(glm::vec3(1.5f, 0, 0.5f));
  const glm::vec3 down(0, 1, 0);
  camera.world_from_camera = glm::mat4(glm::vec4(glm::cross(down, forward), 0), glm::vec4(down, 0),
                                       glm::vec4(forward, 0), glm::vec4(-1.5f, 0, 1.5f, 1));
  const double a = 0.5 / std::sqrt(1.25);
  const double form_factor = 4 * (2 * a * std::atan(a)) / (2 * M_PI);
  const Image image = undivided(render_views(RenderScene(scene, {.light_samples = 1024}), camera, {1024, 0, 5}));
  EXPECT_NEAR(mean(image), 100 * form_factor, 100 * form_factor * 0.005);
}

// What alpha cuts out of a glowing surface is not seen, and gives no light: neither at points nor at samples.
TEST(DirectLight, WhatIsCutOutDoesNotGlow) {
  Scene scene;
  scene.materials = {diffuse(1), glowing(100)};
  scene.materials[1].base_color.w = 0;
  scene.materials[1].alpha_cutoff = 0.5f;
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({-0.5f, -0.5f, 1}, {1, 0, 0}, {0, 1, 0}, 1)};
  for (const double spacing_px : {0.0, 4.0}) {
    const RenderScene world(scene, {.light_spacing_px = spacing_px});
    EXPECT_EQ(mean(undivided(render_views(world, phone_camera(2, 4, 4), {64, 0, 5}))), 0) << spacing_px;
  }
}

// The sky's density integrates to one over the sphere (midpoint rule on a grid that the table's cells divide), is
// positive wherever light could fall on the surface, and is the one that samples report.
TEST(Lights, EnvironmentDensityIntegratesToOneAndIsTheSamplers) {
  Scene scene;
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0)};
  scene.materials = {diffuse(1)};
  scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(1))};
  scene.environment.radiance_nits[11] = glm::vec3(500);
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  for (const glm::vec3 normal : {glm::vec3(0, 1, 0), glm::vec3(0.6f, 0, 0.8f), glm::vec3(-0.48f, -0.6f, -0.64f)}) {
    const int rows = 512;
    double integral = 0;
    for (int i = 0; i < rows; ++i) {
      const double theta = M_PI * (i + 0.5) / rows;
      for (int j = 0; j < 2 * rows; ++j) {
        const double phi = M_PI * (j + 0.5) / rows;
        const glm::vec3 d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
        const double pdf = lights.environment_pdf(glm::vec3(0), normal, d);
        ASSERT_GT(pdf, 0);
        integral += pdf * std::sin(theta) * std::pow(M_PI / rows, 2);
      }
    }
    EXPECT_NEAR(integral, 1, 1e-3);
    int disagreements = 0;
    for (int i = 0; i < 10000; ++i) {
      int lanes[kPacket] = {};
      float u[kPacket] = {}, v[kPacket] = {};
      Vec3Packet points{}, normals{};
      const int lane = i % kPacket;
      lanes[lane] = -1;
      normals.set(lane, normal);
      const int row = i / 100;
      u[lane] = (i % 100 + 0.5f) / 100, v[lane] = (row + 0.5f) / 100;
      LightPacket s;
      lights.sample(lanes, points, normals, u, v, s);
      EXPECT_NEAR(glm::length(s.direction.at(lane)), 1, 1e-6);
      // directions on the border of two cells may round into either
      disagreements += std::abs(lights.environment_pdf(glm::vec3(0), normal, s.direction.at(lane)) - s.pdf[lane]) >
                       1e-3f * s.pdf[lane];
    }
    EXPECT_LT(disagreements, 10);
  }
}

// A sample is worth the light that all lights together throw on the surface, whichever light it went to: here a
// uniform sky of 1000 nits, pi * 1000 lx, and a sun that stands 30 degrees above the surface, or behind it. The sky's
// table overstates it by its lifted cosine: 1.01 (1.09^2 + 0.008) = 1.21 where cosines sum to 1.
TEST(Lights, ShareTheSamplesByWhatTheyThrowOnTheSurface) {
  Scene scene;
  scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(1000))};
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = glm::vec3(20000);
  sun.direction = {0, -0.5f, -std::sqrt(0.75f)};
  scene.lights = {sun};
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  for (float side : {1.0f, -1.0f}) {
    const glm::vec3 normal(0, side, 0);
    const double sun_lux = side > 0 ? 10000 : 0, sky_lux = M_PI * 1000;
    int lanes[kPacket];
    float u[kPacket], v[kPacket];
    Vec3Packet points{}, normals{};
    for (int i = 0; i < kPacket; ++i) lanes[i] = -1, normals.set(i, normal);
    int from_sun = 0, count = 0;
    double sum = 0;
    for (int first = 0; first < 4096; first += kPacket / 2) {
      padded_samples(first, 4095, 3, 0, u, v);
      LightPacket s;
      lights.sample(lanes, points, normals, u, v, s);
      for (int i = 0; i < kPacket; ++i, ++count) {
        const double lux = s.radiance.at(i).g * std::max(glm::dot(normal, s.direction.at(i)), 0.0f);
        sum += lux;
        if (s.pdf[i] > 0) continue;
        ++from_sun;
        EXPECT_GT(lux, sun_lux + sky_lux);
        EXPECT_LT(lux, sun_lux + 1.22 * sky_lux);
      }
    }
    EXPECT_NEAR(sum / count, sun_lux + sky_lux, 0.002 * (sun_lux + sky_lux));
    EXPECT_NEAR(from_sun, count * sun_lux / (sun_lux + 1.21 * sky_lux), 0.005 * count);  // of a net
  }
}

// The density that bsdf_pdf() states is the one that sample_bsdf() has: the mean of f(direction) / pdf over its samples
// is the integral of f over the directions that it reaches. f = cosine to the normal: integral pi.
TEST(Bsdf, SamplesFollowTheirDensity) {
  for (float roughness : {1.0f, 0.5f, 0.25f}) {
    Surface s;
    s.base_color = glm::vec3(0.7f);
    s.metallic = 0.3f;
    s.roughness = roughness;
    const glm::vec3 to_eye = glm::normalize(glm::vec3(0.5f, 0.2f, 1));
    double sum = 0;
    const int n = 512;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const glm::vec3 d = sample_bsdf(s, to_eye, (i + 0.5f) / n, (j + 0.5f) / n);
        if (d.z > 0) sum += d.z / bsdf_pdf(s, to_eye, d);
      }
    }
    EXPECT_NEAR(sum / (n * n), M_PI, 0.01 * M_PI) << "roughness " << roughness;
  }
}

TEST(Bsdf, NoSurfaceGivesBackMoreThanItGets) {
  for (float metallic : {0.0f, 1.0f}) {
    for (float roughness : {0.3f, 0.6f, 1.0f}) {
      Surface s;
      s.base_color = glm::vec3(1);
      s.metallic = metallic;
      s.roughness = roughness;
      const glm::vec3 to_eye = glm::normalize(glm::vec3(1, 0, 1));
      double sum = 0;
      const int n = 256;
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const glm::vec3 d = sample_bsdf(s, to_eye, (i + 0.5f) / n, (j + 0.5f) / n);
          if (d.z > 0) sum += bsdf(s, to_eye, d).x * d.z / bsdf_pdf(s, to_eye, d);
        }
      }
      EXPECT_LT(sum / (n * n), 1.02) << "metallic " << metallic << " roughness " << roughness;
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
