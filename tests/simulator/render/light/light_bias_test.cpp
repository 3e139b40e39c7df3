// What light at points of surfaces leaves wrong, however many samples follow: the bias of LightCache.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <memory>
#include <numeric>
#include <string>

#include "simulator/render/light/light_cache.h"
#include "simulator/render/views.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr int kPictureSide = 256;
constexpr double kGray = 0.18, kFullHalfWell_e = 3000;  ///< of a phone's half photosite, at base ISO

Mesh ball(glm::vec3 center, float radius, int material) {
  constexpr int kAround = 48, kDown = 24;
  Mesh mesh;
  for (int j = 0; j <= kDown; ++j) {
    for (int i = 0; i <= kAround; ++i) {
      const float u = glm::two_pi<float>() * static_cast<float>(i) / kAround;
      const float v = glm::pi<float>() * static_cast<float>(j) / kDown;
      const glm::vec3 normal(std::sin(v) * std::cos(u), std::cos(v), std::sin(v) * std::sin(u));
      mesh.normals.push_back(normal);
      mesh.positions.push_back(center + radius * normal);
      mesh.uv0.push_back({0, 0});
    }
  }
  for (unsigned j = 0; j < kDown; ++j) {
    for (unsigned i = 0; i < kAround; ++i) {
      const unsigned a = j * (kAround + 1) + i, b = a + kAround + 1;
      if (j > 0) mesh.triangles.push_back({a, a + 1, b});
      if (j + 1 < kDown) mesh.triangles.push_back({b, a + 1, b + 1});
    }
  }
  mesh.material = material;
  mesh.object_id = 1;
  return mesh;
}

/// Seen along +z from the origin, y down: a room of 3 x 2.4 x 4 m whose one window lies beside the camera's view.
/// Behind it is a slot of 1 cm, whose light would be missed by light samples alone.
Scene room_with_a_small_window() {
  Scene scene;
  scene.materials = {diffuse(0.7f), diffuse(0.3f), glowing(3000)};
  scene.meshes = {make_quad({-1.5f, 1.2f, -1}, {3, 0, 0}, {0, 0, 4}, 1),         // floor
                  make_quad({-1.5f, -1.2f, -1}, {0, 0, 4}, {3, 0, 0}, 0),        // ceiling
                  make_quad({-1.5f, -1.2f, 3}, {0, 2.4f, 0}, {3, 0, 0}, 0),      // back wall
                  make_quad({-1.5f, -1.2f, -1}, {0, 2.4f, 0}, {0, 0, 4}, 0),     // left wall
                  make_quad({1.5f, -1.2f, -1}, {0, 0, 4}, {0, 2.4f, 0}, 0),      // right wall
                  make_quad({-1.5f, -1.2f, -1}, {3, 0, 0}, {0, 2.4f, 0}, 0),     // behind the camera
                  make_quad({-1.49f, -0.8f, 1}, {0, 0.8f, 0}, {0, 0, 0.6f}, 2),  // window
                  make_quad({-0.2f, 0.6f, 1.6f}, {0.6f, 0, 0.2f}, {0, 0.6f, 0}, 0),
                  make_quad({-0.2f, 0.6f, 1.6f}, {0.2f, 0, 0.6f}, {0.6f, 0, 0.2f}, 1),
                  ball({-0.5f, 0.9f, 1.8f}, 0.3f, 0)};
  return scene;
}

/// To the sky on one side: nothing glows. Under the edge of a plate before the wall, light at points disagrees.
Scene open_room() {
  Scene scene = room_with_a_small_window();
  scene.materials[2] = diffuse(0.3f);
  scene.meshes.erase(scene.meshes.begin() + 3);
  scene.meshes.push_back(make_quad({0.001f, -0.6f, 2.9998f}, {0, 1.2f, 0}, {1, 0, 0}, 0));
  scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(1000))};
  return scene;
}

Scene glossy_balls_under_lamps() {
  Scene scene;
  scene.materials = {diffuse(0.5f), diffuse(0.6f), diffuse(0.6f), glowing(6000), diffuse(0.4f)};
  scene.materials[1].roughness = 0.15f;
  scene.materials[2].roughness = 0.4f;
  scene.materials[4].metallic = 1;
  scene.materials[4].roughness = 0.3f;
  scene.meshes = {make_quad({-4, 0.4f, -1}, {8, 0, 0}, {0, 0, 8}, 0),
                  make_quad({-4, -4, 5}, {0, 8, 0}, {8, 0, 0}, 0),
                  make_quad({-1.2f, -1.5f, 0.8f}, {0.4f, 0, 0}, {0, 0, 0.4f}, 3),
                  make_quad({0.8f, -1.2f, 2.2f}, {0.3f, 0.1f, 0}, {0, 0, 0.3f}, 3),
                  ball({-0.55f, 0.1f, 1.8f}, 0.3f, 1),
                  ball({0.05f, 0.1f, 1.5f}, 0.3f, 2),
                  ball({0.6f, 0.1f, 1.9f}, 0.3f, 4)};
  return scene;
}

struct Halves {
  Image a, b;  ///< of one scene, by samples that are independent, of light at points, too
};

/// The whole of the scene is seen, as a picture of 256 x 256 photosites shows it.
Halves render_twice(const Scene& scene, const LightCacheOptions& cache, int samples, int bounces) {
  RenderScene world(scene, cache);
  const CameraView camera = phone_camera(1.6, kPictureSide, kPictureSide, {}, 4.48e-3 / kPictureSide);
  const auto one = [&](unsigned seed) {
    if (world.light_cache) world.light_cache = std::make_unique<LightCache>(cache, seed);
    return undivided(render_views(world, camera, {samples, bounces, seed}));
  };
  return {one(1), one(2)};
}

struct Bias {
  double squared = 0, standard_error = 0;  ///< mean square over the picture, in a half photosite's shot noise squared
  double light = 0;                        ///< of the whole picture, over what it should be
};

/// The product of two differences with independent noise has the square of the bias as its mean. Its standard error is
/// that of means over blocks, as errors of light at one point reach over many photosites.
Bias bias_of(const Halves& cached, const Halves& sampled) {
  constexpr int kBlock = 8, kBlocks = kPictureSide / kBlock;
  const auto sum = [](const Image& image) { return std::accumulate(image.data.begin(), image.data.end(), 0.0); };
  const double mean = sum(sampled.a) / static_cast<double>(sampled.a.data.size());
  const double noise_at_gray = mean / std::sqrt(kGray * kFullHalfWell_e);
  std::vector<double> blocks(kBlocks * kBlocks);
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = 0; x < kPictureSide; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double a = sampled.a.at(x, y, c), b = sampled.b.at(x, y, c);
        const double variance = noise_at_gray * noise_at_gray * std::max(0.5 * (a + b), 0.1 * mean) / mean;
        blocks[y / kBlock * kBlocks + x / kBlock] +=
            (cached.a.at(x, y, c) - a) * (cached.b.at(x, y, c) - b) / (3 * kBlock * kBlock * variance);
      }
    }
  }
  const auto count = static_cast<double>(blocks.size());
  Bias bias;
  bias.squared = std::accumulate(blocks.begin(), blocks.end(), 0.0) / count;
  double squares = 0;
  for (const double block : blocks) squares += (block - bias.squared) * (block - bias.squared);
  bias.standard_error = std::sqrt(squares) / count;
  bias.light = (sum(cached.a) + sum(cached.b)) / (sum(sampled.a) + sum(sampled.b));
  return bias;
}

/// At the default distance of points, a tenth of the sensor's noise is the most that is allowed, and light is kept to
/// .2 %. Measured, squared: .002 to .010, with standard errors of .001 to .008; without closer points up to .4.
void expect_a_tenth(const Scene& scene, int samples, int bounces) {
  const Bias bias = bias_of(render_twice(scene, {.light_samples = 1024}, samples, bounces),
                            render_twice(scene, {.light_spacing_px = 0}, samples, bounces));
  const auto what = std::to_string(scene.meshes.size()) + " meshes, " + std::to_string(bounces) + " reflections";
  EXPECT_LT(bias.squared - 2 * bias.standard_error, 0.1 * 0.1) << what;
  EXPECT_LT(bias.standard_error, 0.1 * 0.1) << what;
  EXPECT_NEAR(bias.light, 1, 0.002) << what;
}

}  // namespace

TEST(SlowLightBias, IsATenthOfTheSensorsNoiseAtMost) {
  expect_a_tenth(room_with_a_small_window(), 64, 0);
  expect_a_tenth(glossy_balls_under_lamps(), 64, 0);
}

// Light from the sky and reflected light are noisier, so that knowing their bias as well takes seven CPU minutes.
TEST(SweepLightBias, IsATenthOfTheSensorsNoiseAtMost) {
  for (const Scene& scene : {room_with_a_small_window(), open_room(), glossy_balls_under_lamps()}) {
    for (const int bounces : {0, 3}) expect_a_tenth(scene, 256, bounces);
  }
}

// Linear interpolation errs by the square of the spacing, and beside shadows' edges in as many photosites as it spans.
TEST(SweepLightBias, FallsWithTheDistanceOfPoints) {
  const Scene scene = glossy_balls_under_lamps();
  const Halves sampled = render_twice(scene, {.light_spacing_px = 0}, 256, 0);
  const auto squared = [&](double spacing_px) {
    return bias_of(render_twice(scene, {.light_spacing_px = spacing_px, .light_samples = 1024}, 256, 0), sampled)
        .squared;
  };
  EXPECT_LT(squared(4), squared(16) / 4);
}

}  // namespace dualpixel::simulator::testing
