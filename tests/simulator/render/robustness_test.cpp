// Geometry at which ray tracers leak, darken or fail.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

Environment even_sky(float nits) { return {2, 1, {glm::vec3(nits), glm::vec3(nits)}}; }

/// As many quads as make each side of a cube around the origin a net of n x n, so that many edges are shared.
Mesh box(float half, int n, glm::vec3 centre) {
  Mesh mesh;
  mesh.material = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (float side : {-half, half}) {
      const auto first = static_cast<unsigned>(mesh.positions.size());
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
          glm::vec3 p;
          p[axis] = side;
          p[(axis + 1) % 3] = half * (2.0f * static_cast<float>(i) / static_cast<float>(n) - 1);
          p[(axis + 2) % 3] = half * (2.0f * static_cast<float>(j) / static_cast<float>(n) - 1);
          mesh.positions.push_back(centre + p);
        }
      }
      const auto row = static_cast<unsigned>(n + 1);
      for (unsigned i = 0; i < static_cast<unsigned>(n); ++i) {
        for (unsigned j = 0; j < static_cast<unsigned>(n); ++j) {
          const unsigned at = first + i * row + j;
          mesh.triangles.push_back({at, at + 1, at + row + 1});
          mesh.triangles.push_back({at, at + row + 1, at + row});
        }
      }
    }
  }
  return mesh;
}

/// Darkest and brightest green of left + right.
std::pair<float, float> range_of(const Scene& scene, const CameraView& camera, int bounces = 0) {
  const Image image = undivided(render_views(RenderScene(scene), camera, {64, bounces, 5}));
  std::pair<float, float> range{INFINITY, -INFINITY};
  for (std::size_t i = 1; i < image.data.size(); i += 3) {
    EXPECT_TRUE(std::isfinite(image.data[i]));
    range.first = std::min(range.first, image.data[i]);
    range.second = std::max(range.second, image.data[i]);
  }
  return range;
}

// A box that is closed but for rounding keeps a sky of a million nits out, of the corners too, after two reflections
// as well: not one of the 800 000 paths of each size gets out.
TEST(Robustness, ClosedBoxesLetNothingIn) {
  for (float half : {0.01f, 0.97f, 1.3e4f}) {
    Scene scene;
    scene.materials = {diffuse(0.9f)};
    scene.materials[0].double_sided = true;
    scene.meshes = {box(half, 16, glm::vec3(0))};
    scene.environment = even_sky(1e6f);
    // a wide view: a phone's lens in front of large photosites, into a corner of the box
    CameraView camera = phone_camera(1, 64, 64, {}, 1.4e-4);
    const glm::vec3 forward = glm::normalize(glm::vec3(1)), right = glm::normalize(glm::vec3(1, 0, -1));
    camera.world_from_camera = glm::mat4(glm::vec4(right, 0), glm::vec4(glm::cross(forward, right), 0),
                                         glm::vec4(forward, 0), glm::vec4(0.1f * half * glm::vec3(1, -1, 0.5f), 1));
    for (int bounces : {0, 1, 2}) EXPECT_EQ(range_of(scene, camera, bounces).second, 0) << half << " " << bounces;
  }
}

// A sheet that fills half the sky reflects albedo times the sky's other half, from millimetres to tens of kilometres:
// nothing that a surface throws back is shadowed by itself.
TEST(Robustness, WallsOfAllSizesDoNotShadowThemselves) {
  for (float size : {1e-3f, 1e-2f, 1.0f, 1e2f, 1e4f}) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {make_quad({-5 * size, -5 * size, size}, {10 * size, 0, 0}, {0, 10 * size, 0}, 0)};
    scene.environment = even_sky(100);
    const auto [low, high] = range_of(scene, phone_camera(size > 0.01f ? size : 0.01, 24, 24));
    // the light sampler's table is flat within a cell of 11 degrees, where cosines are not: a sample's worth spreads by
    // a fifth, the mean of 64 by 2.5 % of 50 at worst; over 576 photosites the extremes lie three of these away
    EXPECT_NEAR(low, 50, 4) << size;
    EXPECT_NEAR(high, 50, 4) << size;
  }
}

// Under a sun straight above it a floor has albedo / pi of its illuminance, seen from however flat: 89.9 degrees.
TEST(Robustness, GrazingViewsKeepTheirLight) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-1e3f, 0.02f, 0.01f}, {2e3f, 0, 0}, {0, 0, 2e3f}, 0)};
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = glm::vec3(1000 * M_PI);
  sun.direction = {0, 1, 0};
  scene.lights = {sun};
  CameraView camera = phone_camera(10, 24, 24);
  camera.world_from_camera = glm::mat4(1);
  const double down = 0.1 * M_PI / 180 + 12 * 1.4e-6 / 4.442e-3;  // of the middle: the topmost ray is the flattest
  camera.world_from_camera[1] = glm::vec4(0, std::cos(down), -std::sin(down), 0);
  camera.world_from_camera[2] = glm::vec4(0, std::sin(down), std::cos(down), 0);
  const auto [low, high] = range_of(scene, camera);
  EXPECT_NEAR(low, 500, 0.5);
  EXPECT_NEAR(high, 500, 0.5);
}

// Two sheets in one place look like one, whichever of them a ray meets.
TEST(Robustness, CoplanarSheetsDoNotShadowEachOther) {
  for (float size : {0.1f, 10.0f, 1e3f}) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    const glm::vec3 a(0.6f * size, 0.01f * size, 0.3f * size), b(0.02f * size, 0.7f * size, -0.1f * size);
    const glm::vec3 corner = glm::vec3(0, 0, size) - 5.0f * (a + b);
    // the second one's triangles are cut elsewhere: its plane is the same but for rounding
    scene.meshes = {make_quad(corner, 10.0f * a, 10.0f * b, 0), make_quad(corner - a, 11.0f * a, 10.5f * b, 0)};
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::directional;
    sun.intensity = glm::vec3(1000 * M_PI);
    const glm::vec3 normal = glm::normalize(glm::cross(b, a));
    sun.direction = -normal;
    scene.lights = {sun};
    const auto [low, high] = range_of(scene, phone_camera(size, 32, 32));
    EXPECT_NEAR(low, 500, 0.5) << size;
    EXPECT_NEAR(high, 500, 0.5) << size;
  }
}

// Triangles a metre long and a micrometre wide, one without area, sheets through the lens's own plane and through its
// pupil: numbers come out, and no more light than the sky has.
TEST(Robustness, SliversAndSheetsThroughTheLensStayFinite) {
  Scene scene;
  scene.materials = {diffuse(0.9f)};
  scene.materials[0].double_sided = true;
  Mesh slivers;
  slivers.material = 0;
  for (unsigned i = 0; i < 400; ++i) {
    const float x = 1e-3f * (static_cast<float>(i) - 200);
    slivers.positions.insert(slivers.positions.end(), {{x, -0.5f, 1}, {x + 1e-6f, -0.5f, 1}, {x, 0.5f, 1.0001f}});
    slivers.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    slivers.triangles.push_back({3 * i, 3 * i, 3 * i + 2});
  }
  scene.meshes = {slivers, make_quad({-1, -1e-4f, 0}, {2, 0, 0}, {0, 0, 2}, 0),  // along the axis, through the pupil
                  make_quad({-1, 1e-3f, 0}, {2, 0, 0}, {0, 1, 0}, 0)};           // in the lens's plane, half of it
  scene.environment = even_sky(100);
  const auto [low, high] = range_of(scene, phone_camera(1, 48, 48), 2);
  EXPECT_GE(low, 0);
  EXPECT_LE(high, 100 * 1.1);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
