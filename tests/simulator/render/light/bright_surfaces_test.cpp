// Paths sent towards surfaces close to a lamp, against paths that find them by chance.
#include "simulator/render/light/bright_surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "simulator/render/views.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// A bulb in a box that is open towards the floor, and hides it from the camera. `shade`: the box's material.
Scene lamp_in_a_shade(const Material& shade) {
  Scene scene;
  scene.materials = {diffuse(0.7f), shade, glowing(30000)};
  const auto box = [&](glm::vec3 low, glm::vec3 size, int material) {
    const glm::vec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
    scene.meshes.push_back(make_quad(low, x, z, material));  // top: y grows downwards
    scene.meshes.push_back(make_quad(low, y, x, material));
    scene.meshes.push_back(make_quad(low + z, x, y, material));
    scene.meshes.push_back(make_quad(low, z, y, material));
    scene.meshes.push_back(make_quad(low + x, y, z, material));
  };
  box({-1.5f, -1.2f, -1}, {3, 2.4f, 4}, 0);  // the room
  scene.meshes.push_back(make_quad({-1.5f, 1.2f, -1}, {3, 0, 0}, {0, 0, 4}, 0));
  box({-0.1f, -0.9f, 1.5f}, {0.2f, 0.15f, 0.2f}, 1);  // the shade
  scene.meshes.push_back(make_quad({-0.03f, -0.85f, 1.57f}, {0.06f, 0, 0}, {0, 0, 0.06f}, 2));
  return scene;
}

struct Spread {
  double mean = 0, standard_error = 0;
};

/// Mean light of pictures of 8 mm of wall, with independent samples, of light at points, too.
Spread light_of(RenderScene& world, int pictures) {
  double sum = 0, squares = 0;
  for (int seed = 1; seed <= pictures; ++seed) {
    if (world.light_cache) world.light_cache = std::make_unique<LightCache>(world.light_cache->options, seed);
    const RenderOptions options{.samples_per_pixel = 64, .max_bounces = 3, .seed = static_cast<std::uint64_t>(seed)};
    const Image image = undivided(render_views(world, phone_camera(1.6, 16, 16), options));
    double light = 0;
    for (const float value : image.data) light += value / static_cast<double>(image.data.size());
    sum += light, squares += light * light;
  }
  const double mean = sum / pictures;
  return {mean, std::sqrt(std::max(squares / pictures - mean * mean, 0.0) / (pictures - 1))};
}

}  // namespace

TEST(BrightSurfaces, AreThoseAroundLamps) {
  const Scene scene = lamp_in_a_shade(diffuse(0.6f));
  const RenderScene world(scene);
  EXPECT_GT(world.bright.share(), 0.2f);
  for (unsigned mesh = 0; mesh < scene.meshes.size(); ++mesh) {
    const bool shade = scene.meshes[mesh].material == 1;
    EXPECT_EQ(world.bright.met(mesh, 0) >= 0, shade) << mesh;
  }
}

// Directions to a surface are as dense as pdf() says: the mean of 1 / pdf is the solid angle that they fill.
TEST(BrightSurfaces, DensityIsThatOfDirections) {
  Scene scene = lamp_in_a_shade(diffuse(0.6f));
  const RenderScene world(scene);
  const glm::vec3 point(0, 1, 1.6f);
  constexpr int kSide = 256;
  double solid_angle = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const int column = i % kSide, row = i / kSide;
    const float u = (column + 0.5f) / kSide, v = (row + 0.5f) / kSide;
    const BrightSurfaces::Target target = world.bright.towards(point, u, v);
    const auto hit = world.intersector.intersect(Ray{point, target.direction});
    if (!hit || world.bright.met(hit->mesh, hit->triangle) != target.triangle) continue;
    // counted on the top of the shade alone, which nothing hides from here but the bulb
    if (scene.meshes[hit->mesh].positions[0].y > -0.9f + 1e-6f || std::abs(target.direction.y * hit->t + 1.9f) > 1e-3f)
      continue;
    solid_angle +=
        1 / (static_cast<double>(world.bright.pdf(target.triangle, target.direction, hit->t)) * kSide * kSide);
  }
  // a rectangle of 2a x 2b at distance d, seen from above its middle, less the bulb's
  const auto rectangle = [](double a, double d) { return 4 * std::asin(a * a / (a * a + d * d)); };
  EXPECT_NEAR(solid_angle, rectangle(0.1, 1.9) - rectangle(0.03, 1.85), 0.01 * rectangle(0.1, 1.9));
}

// The mean is that of paths that find them by chance, also where the shade glows itself and where it reflects as metal
// does, and whether light is kept at points or sampled by every path. Its error is .12 to .24 of theirs.
TEST(SlowBrightSurfaces, ChangeNothingButTheNoise) {
  Material glows = diffuse(0.6f), metal = diffuse(0.6f);
  glows.emission_nits = glm::vec3(300);
  metal.metallic = 1, metal.roughness = 0.5f;
  for (const Material& shade : {diffuse(0.6f), glows, metal}) {
    for (const double spacing_px : {0.0, 4.0}) {
      const Scene scene = lamp_in_a_shade(shade);
      RenderScene world(scene, {.light_spacing_px = spacing_px});
      const Spread sent = light_of(world, 40);
      world.bright = {};
      const Spread plain = light_of(world, 40);
      EXPECT_LT(std::abs(sent.mean - plain.mean), 3 * std::hypot(sent.standard_error, plain.standard_error))
          << sent.mean << " and " << plain.mean;
      EXPECT_LT(sent.standard_error, 0.4 * plain.standard_error);
    }
  }
}

}  // namespace dualpixel::simulator::testing
