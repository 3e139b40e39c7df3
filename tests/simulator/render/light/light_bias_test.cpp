// What light at points of surfaces leaves wrong, however many samples follow: the bias of LightCache.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <memory>

#include "simulator/render/light/light_cache.h"
#include "simulator/render/views.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr int kPictureSide = 64;
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

Halves render_twice(const Scene& scene, const LightCacheOptions& cache, int samples, int bounces) {
  RenderScene world(scene, cache);
  const CameraView camera = phone_camera(1.6, kPictureSide, kPictureSide);
  const auto one = [&](unsigned seed) {
    if (world.light_cache) world.light_cache = std::make_unique<LightCache>(cache, seed);
    return undivided(render_views(world, camera, {samples, bounces, seed}));
  };
  return {one(1), one(2)};
}

/// RMS over the picture, in a half photosite's shot noise. The product of two differences with independent noise has
/// the square of the bias as its mean.
double bias_over_noise(const Halves& cached, const Halves& sampled) {
  double mean = 0, squares = 0;
  for (const float value : sampled.a.data) mean += value / static_cast<double>(sampled.a.data.size());
  const double noise_at_gray = mean / std::sqrt(kGray * kFullHalfWell_e);
  for (std::size_t i = 0; i < sampled.a.data.size(); ++i) {
    const double light = std::max(0.5 * (sampled.a.data[i] + sampled.b.data[i]), 0.1 * mean);
    const double variance = noise_at_gray * noise_at_gray * light / mean;
    squares += (cached.a.data[i] - static_cast<double>(sampled.a.data[i])) *
               (cached.b.data[i] - static_cast<double>(sampled.b.data[i])) / variance;
  }
  return std::sqrt(std::max(squares, 0.0) / static_cast<double>(sampled.a.data.size()));
}

double mean_light(const Halves& halves) {
  double sum = 0;
  for (const Image* image : {&halves.a, &halves.b}) {
    for (const float value : image->data) sum += value;
  }
  return sum / static_cast<double>(2 * halves.a.data.size());
}

}  // namespace

// A tenth of the sensor's noise is the most that is allowed at the default distance of points. The camera sees 6 cm of
// wall; a picture of the whole room does not keep it (docs/rendering.md, "What is not met").
TEST(SlowLightBias, IsATenthOfTheSensorsNoiseAtMost) {
  const auto bias = [](const Scene& scene, int bounces) {
    return bias_over_noise(render_twice(scene, {.light_samples = 1024}, 512, bounces),
                           render_twice(scene, {.light_spacing_px = 0}, 2048, bounces));
  };
  EXPECT_LT(bias(room_with_a_small_window(), 0), 0.1);
  EXPECT_LT(bias(glossy_balls_under_lamps(), 0), 0.1);
  EXPECT_LT(bias(glossy_balls_under_lamps(), 3), 0.1);
}

// Behind the window is a slot of 1 cm, whose light would be missed by light samples alone. With one reflection the two
// halves of the mean differ by .22 %, so that its standard error is .11 %.
TEST(SlowLightBias, RoomsKeepTheirReflectedLight) {
  // To the sky on one side: nothing glows. Under the edge of a plate before the wall, light at points disagrees.
  Scene open = room_with_a_small_window();
  open.materials[2] = diffuse(0.3f);
  open.meshes.erase(open.meshes.begin() + 3);
  open.meshes.push_back(make_quad({0.001f, -0.6f, 2.9998f}, {0, 1.2f, 0}, {1, 0, 0}, 0));
  open.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(1000))};
  for (const Scene& room : {room_with_a_small_window(), open}) {
    for (int bounces : {1, 3}) {
      const double sampled = mean_light(render_twice(room, {.light_spacing_px = 0}, 1024, bounces));
      const double at_points = mean_light(render_twice(room, {.light_samples = 1024}, 256, bounces));
      EXPECT_NEAR(at_points / sampled, 1, 0.004) << bounces << " reflections, " << room.meshes.size() << " meshes";
    }
  }
}

}  // namespace dualpixel::simulator::testing
