// Strands of hair in pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/render/shading/hair.h"
#include "simulator/render/truth.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// Straight strands of white hair side by side, 1 m away, that leave no gap: each 1 mm wide.
Mesh comb(int strands, float spacing_m) {
  Mesh mesh;
  mesh.object_id = 1;
  const int middle = strands / 2;
  for (int i = 0; i < strands; ++i) {
    const float x = static_cast<float>(i - middle) * spacing_m;
    const auto first = static_cast<unsigned>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{x, -0.2f, 1}, {x + 0.01f, 0, 1.01f}, {x, 0.2f, 1}});
    mesh.radii.insert(mesh.radii.end(), 3, 0.0005f);
    mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first}, {first + 1, first + 2, first + 1}});
  }
  return mesh;
}

Scene scene_of(Mesh mesh, float color) {
  Scene scene;
  scene.materials = {diffuse(color)};
  scene.materials[0].roughness = 0.4f;
  scene.meshes = {std::move(mesh)};
  return scene;
}

double mean_of(const Image& image) {
  double sum = 0;
  for (const float v : image.data) sum += v;
  return sum / static_cast<double>(image.data.size());
}

// White hair in an even sky is invisible: one layer of it, with light from all around, at enough reflections for what
// goes to and fro between neighbors.
TEST(Strands, AreInvisibleInAFurnace) {
  Scene scene = scene_of(comb(60, 0.001f), 1);
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(100)}};
  const RenderScene world(scene);
  const CameraView camera = phone_camera(1, 16, 16);
  EXPECT_NEAR(mean_of(undivided(render_views(world, camera, {256, 30, 5}))), 100, 1);
}

// Light from behind, far to the side, that one strand scatters: the integral of its scattering over its width, times
// lux. The sun's direction is one of the directions that half of the light samples look to.
TEST(Strands, ScatterTheSun) {
  Mesh mesh;
  mesh.positions = {{0, -0.2f, 1}, {0, 0.2f, 1}};
  mesh.radii = {0.01f, 0.01f};
  mesh.triangles = {{0, 1, 0}};
  Scene scene = scene_of(mesh, 0.7f);
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = glm::vec3(10000);
  sun.direction = glm::normalize(glm::vec3(0.5f, 0.3f, -0.4f));
  scene.lights = {sun};
  // .04 m of it are in view: the strand covers half, and rays are nearly parallel
  const CameraView camera = phone_camera(1, 64, 2, {}, 2.8e-6);
  const double nits = mean_of(undivided(render_views(RenderScene(scene), camera, {1024, 0, 5})));
  double expected = 0;
  constexpr int kAcross = 400;
  for (int i = 0; i < kAcross; ++i) {
    const HairStrand strand{{0, 1, 0}, 2 * (i + 0.5f) / kAcross - 1, glm::vec3(0.7f), 0.4f};
    expected += 10000 * hair_scattering(strand, {0, 0, -1}, -sun.direction).y / kAcross;
  }
  const double image_distance_m = 1 / (1 / 4.442e-3 - 1), covers = 0.02 / (64 * 2.8e-6 / image_distance_m);
  EXPECT_NEAR(nits, expected * covers, 0.01 * expected * covers);
}

TEST(Strands, HaveTruth) {
  Scene scene = scene_of(comb(1, 1), 1);
  scene.meshes[0].radii = {0.01f, 0.01f, 0.01f};
  scene.meshes[0].person = true;
  const Truth truth = trace_truth(RenderScene(scene), phone_camera(1, 8, 8));
  EXPECT_NEAR(truth.depth_m.at(4, 4), 1.01, 1e-3);
  EXPECT_EQ(truth.person_mask.at(4, 4), 1);
  EXPECT_LT(truth.normal.at(4, 4, 2), -0.99);
}

// A leaning strand .4 photosites wide: the middles of most photosites miss it, and the mask has all of its area.
TEST(Strands, CoverAPartOfThePersonMask) {
  constexpr int kSide = 32;
  constexpr double kWidth = 0.4, kLean = 0.23;
  const CameraView camera = phone_camera(1, kSide, kSide);
  const auto photosite_m = static_cast<float>(1.4e-6 / thin(camera).image_distance_m());  // at 1 m
  Mesh strand;
  strand.object_id = 1;
  strand.person = true;
  for (const float v : {-30.0f, 30.0f}) {
    strand.positions.push_back({static_cast<float>(kLean) * v * photosite_m, v * photosite_m, 1});
    strand.radii.push_back(static_cast<float>(kWidth / 2) * photosite_m);
  }
  strand.triangles = {{0, 1, 0}};
  const Truth truth = trace_truth(RenderScene(scene_of(strand, 1)), camera);
  double area = 0;
  int halves = 0;
  for (const float v : truth.person_mask.data) {
    area += v;
    halves += v > 0 && v < 1 ? 1 : 0;
    EXPECT_LT(v, 0.7);
  }
  const double expected = kSide * kWidth * std::sqrt(1 + kLean * kLean);
  EXPECT_NEAR(area, expected, 0.04 * expected);  // 16 rays a photosite
  EXPECT_GT(halves, kSide);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
