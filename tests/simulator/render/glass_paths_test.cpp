// Light through glass against closed forms.
#include "simulator/render/glass_paths.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "simulator/render/motion.h"
#include "simulator/render/truth.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// Clear glass of ior 1.5, which reflects .04 head-on.
Material glass(glm::vec3 color, bool solid, glm::vec3 absorption_per_m = glm::vec3(0)) {
  Material m;
  m.base_color = glm::vec4(color, 1);
  m.metallic = m.roughness = 0;
  m.layers.emplace();
  m.layers->transmission = 1;
  m.layers->solid = solid;
  m.layers->absorption_per_m = absorption_per_m;
  return m;
}

/// Faces outward: a pane from z0 to z1 that fills the view.
Mesh slab(float z0, float z1, int material) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({(i & 1 ? 5.0f : -5.0f), (i & 2 ? 5.0f : -5.0f), (i & 4 ? z1 : z0)});
  }
  mesh.triangles = {{0, 3, 1}, {0, 2, 3}, {4, 7, 6}, {4, 5, 7}, {0, 5, 4}, {0, 1, 5},
                    {2, 7, 3}, {2, 6, 7}, {0, 6, 2}, {0, 4, 6}, {1, 7, 5}, {1, 3, 7}};
  mesh.material = material;
  mesh.object_id = 2;
  return mesh;
}

Mesh glass_ball(glm::vec3 center, float radius, int material) {
  constexpr int kRows = 48, kColumns = 96;
  Mesh mesh;
  mesh.material = material;
  mesh.object_id = 2;
  for (int i = 0; i <= kRows; ++i) {
    for (int j = 0; j <= kColumns; ++j) {
      const double theta = M_PI * i / kRows, phi = 2 * M_PI * j / kColumns;
      const glm::vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      mesh.normals.push_back(n);
      mesh.positions.push_back(center + radius * n);
    }
  }
  for (unsigned i = 0; i < kRows; ++i) {
    for (unsigned j = 0; j < kColumns; ++j) {
      const unsigned a = i * (kColumns + 1) + j, b = a + 1, c = a + kColumns + 1, d = c + 1;
      if (i > 0) mesh.triangles.emplace_back(a, b, c);
      if (i + 1 < kRows) mesh.triangles.emplace_back(b, d, c);
    }
  }
  return mesh;
}

glm::dvec3 mean_of(const Image& image, int x0, int x1) {
  glm::dvec3 sum(0);
  for (int y = 0; y < image.height; ++y) {
    for (int x = x0; x < x1; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += image.at(x, y, c);
    }
  }
  return sum / double((x1 - x0) * image.height);
}

/// Each color as its photosites see it: the same as if all of them did, since what they see is even.
glm::dvec3 seen(const Scene& scene, int samples = 256, int max_bounces = 0, LightCacheOptions cache = {}) {
  glm::dvec3 rgb;
  for (int c = 0; c < 3; ++c) {
    RenderOptions options{samples, max_bounces, 5};
    options.color = c;
    const Image image = undivided(render_views(RenderScene(scene, cache), phone_camera(1, 8, 8), options));
    rgb[c] = mean_of(image, 0, 8)[image.channels > 1 ? c : 0];
  }
  return rgb;
}

// A lamp behind a pane of ior 1.5 and color (.9, .6, .3), at no reflections: .96 times the color of its light. What the
// pane reflects is black.
TEST(GlassPaths, LampThroughAThinPane) {
  Scene scene;
  scene.materials = {glowing(1000), glass({0.9f, 0.6f, 0.3f}, false)};
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0), make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 1)};
  const glm::dvec3 rgb = seen(scene);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], 960 * scene.materials[1].base_color[c], 0.1) << c;
}

// The same lamp in a mirror of color .8, behind the camera: .8 of its light, at no reflections.
TEST(GlassPaths, LampInAMirror) {
  Scene scene;
  scene.materials = {glowing(1000), diffuse(0.8f)};
  scene.materials[1].metallic = 1, scene.materials[1].roughness = 0;
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 1)};
  EXPECT_NEAR(seen(scene).y, 800, 8);
}

// A pane of ior 1.5 and color (.9, .6, .3) before one glowing wall, and another behind the camera. Every sample follows
// both ways, so that every photosite sees F B + (1 - F) c A, F = .04, and none any noise. A way taken by chance leaves
// some sqrt(.15 * .85 / 16), or 9 %, at 16 samples.
TEST(GlassPaths, APaneShowsBothWallsWithoutNoise) {
  constexpr float kBehind = 100, kReflected = 2000;  // nits
  Scene scene;
  scene.materials = {glowing(0), glowing(0), glass({0.9f, 0.6f, 0.3f}, false)};
  for (int i = 0; i < 2; ++i) scene.materials[i].unlit = true;
  scene.unlit_white_nits = kReflected;
  scene.materials[0].base_color = glm::vec4(glm::vec3(kBehind / kReflected), 1);
  scene.materials[1].base_color = glm::vec4(1);
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0), make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 1),
                  make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 2)};
  const auto views_by = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    RenderOptions options{16, 1, 5};
    options.color = 1;
    return render_views(RenderScene(scene), phone_camera(1, 16, 16), options);
  };
  const Views views = views_by(1), again = views_by(2);
  EXPECT_EQ(views.left.data, again.left.data);
  EXPECT_EQ(views.right.data, again.right.data);
  const Image image = undivided(views);
  for (int i = 0; i < image.width * image.height; ++i) {
    for (int c = 0; c < 3; ++c) {
      const double seen = 0.96 * scene.materials[2].base_color[c] * kBehind + 0.04 * kReflected;
      // microfacets of a clear pane lean by a thousandth, and those that lean far carry less
      EXPECT_NEAR(image.data[3 * i + c], seen, 0.002 * seen);
    }
  }
}

// A slab of solid glass, d = .1 m, absorbing a = exp(-k d): reflected to and fro inside, it lets
// (1 - F)^2 a / (1 - F^2 a^2) of a lamp's light through head-on, F = .04 (geometric series).
TEST(GlassPaths, LampThroughASolidSlab) {
  const glm::vec3 absorption(0.5f, 5, 20);
  Scene scene;
  scene.materials = {glowing(1000), glass(glm::vec3(1), true, absorption)};
  scene.meshes = {make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 0), slab(1, 1.1f, 1)};
  const glm::dvec3 rgb = seen(scene, 1024);
  for (int c = 0; c < 3; ++c) {
    const double a = std::exp(-0.1 * absorption[c]), passes = 0.96 * 0.96 * a / (1 - 0.0016 * a * a);
    EXPECT_NEAR(rgb[c], 1000 * passes, 8 + 4 * a) << c;
  }
}

// A glass ball in an even sky neither adds nor takes light: it is invisible. Clear and rough.
TEST(SlowGlassPaths, BallInAFurnaceIsInvisible) {
  for (const float roughness : {0.0f, 0.2f}) {
    Scene scene;
    scene.materials = {glass(glm::vec3(1), true)};
    scene.materials[0].roughness = roughness;
    scene.meshes = {glass_ball({0, 0, 1}, 0.5f, 0)};
    scene.environment = {2, 1, {glm::vec3(100), glm::vec3(100)}};
    const double nits = seen(scene, 1024).y;
    EXPECT_LT(nits, 101);
    EXPECT_GT(nits, roughness == 0 ? 99 : 92);  // masked microfacets lose the rest
  }
}

// A point light in the middle of a ball of absorbing glass that bends nothing, r = .5 m, shines on a wall 2 m away:
// its rays end in the glass that they enter. The ball is of flat faces, .5 % nearer to its middle at most.
TEST(GlassPaths, ALampInGlassIsDimmedByIt) {
  const glm::vec3 absorption(0.5f, 2, 5);
  Scene scene;
  scene.materials = {diffuse(1), glass(glm::vec3(1), true, absorption)};
  scene.materials[1].layers->ior = 1;
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0), glass_ball({0, 0, -1}, 0.5f, 1)};
  PunctualLight lamp;
  lamp.intensity = glm::vec3(80);
  lamp.position = {0, 0, -1};
  scene.lights = {lamp};
  for (const double spacing : {0.0, 4.0}) {
    const glm::dvec3 rgb = seen(scene, 16, 0, {.light_spacing_px = spacing});
    for (int c = 0; c < 3; ++c) {
      const double exact = 80.0 / 4 / M_PI * std::exp(-0.5 * absorption[c]);
      EXPECT_NEAR(rgb[c], exact, (0.005 + 0.0025 * absorption[c]) * exact) << c << ", " << spacing;
    }
  }
}

// A directional light of 10000 lx through a tinted pane onto a wall of albedo .5, at points on surfaces and sampled by
// each path. The camera is on the wall's side of the pane.
TEST(GlassPaths, PaneTintsTheSun) {
  Scene scene;
  scene.materials = {diffuse(0.5f), glass({1, 0.5f, 0.25f}, false)};
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0),
                  make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 1)};
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = glm::vec3(10000);
  sun.direction = {0, 0, 1};
  scene.lights = {sun};
  for (const double spacing : {0.0, 4.0}) {
    const glm::dvec3 rgb = seen(scene, 16, 0, {.light_spacing_px = spacing});
    for (int c = 0; c < 3; ++c) {
      const double passes = 0.96 * scene.materials[1].base_color[c];
      EXPECT_NEAR(rgb[c], 0.5 * 10000 * passes / M_PI, 0.5) << c << ", " << spacing;
    }
  }
}

// A lamp of 1 x 1 m behind a pane, the wall next to it: light samples and reflections find the same light through the
// pane, so that their weights add up. The pane is of ior 1, which tints and does nothing else: half of the light
// without.
TEST(GlassPaths, LightAndReflectionSamplesAgreeThroughAPane) {
  const auto wall = [&](bool pane, float roughness, double spacing, int bounces) {
    Scene scene;
    scene.materials = {diffuse(0.8f), glowing(1000), glass(glm::vec3(0.5f), false)};
    scene.materials[0].roughness = roughness;
    scene.materials[2].layers->ior = 1;
    scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0),
                    make_quad({-0.5f, -0.5f, -0.5f}, {1, 0, 0}, {0, 1, 0}, 1)};
    if (pane) scene.meshes.push_back(make_quad({-5, -5, -0.25f}, {10, 0, 0}, {0, 10, 0}, 2));
    return seen(scene, 1024, bounces, {.light_spacing_px = spacing, .light_samples = 1024}).y;
  };
  for (const double spacing : {0.0, 4.0}) {
    for (const float roughness : {1.0f, 0.3f}) {
      const double without = wall(false, roughness, spacing, 0), with = wall(true, roughness, spacing, 0);
      EXPECT_NEAR(with, 0.5 * without, 0.01 * without) << roughness << ", " << spacing;
    }
  }
}

// A glossy board beside a glass ball in an even sky is no brighter than without the ball, which bends much of what the
// board reflects to where its light samples do not look: behind it. Clear and rough.
TEST(SlowGlassPaths, BallBesideABoardAddsNoLight) {
  const auto board = [](bool ball, float roughness) {
    Scene scene;
    scene.materials = {diffuse(1), glass(glm::vec3(1), true)};
    scene.materials[0].roughness = 0.3f;
    scene.materials[1].roughness = roughness;
    scene.meshes = {make_quad({-0.1f, -0.1f, 1}, {0.2f, 0, 0}, {0, 0.2f, 0}, 0)};
    if (ball) scene.meshes.push_back(glass_ball({0.4f, 0, 0.75f}, 0.35f, 1));
    scene.environment = {2, 1, {glm::vec3(100), glm::vec3(100)}};
    return seen(scene, 1024, 1, {.light_spacing_px = 0}).y;
  };
  const double without = board(false, 0);
  for (const float roughness : {0.0f, 0.2f}) {
    const double with = board(true, roughness);
    EXPECT_LT(with, 1.01 * without) << roughness;  // the mean of 65536 samples is off by .3 %
    EXPECT_GT(with, 0.85 * without) << roughness;
  }
}

// Clear panes are looked through, one or two; dark panes and solid glass are what is seen.
TEST(GlassPaths, TruthIsBehindPanesAndOnSolidGlass) {
  Scene scene;
  scene.materials = {diffuse(0.5f), glass(glm::vec3(1), false), glass(glm::vec3(0.4f), false),
                     glass(glm::vec3(1), true)};
  const auto at = [&](float z, int material) { return make_quad({-5, -5, z}, {10, 0, 0}, {0, 10, 0}, material); };
  const auto depth = [&](std::vector<Mesh> meshes) {
    scene.meshes = std::move(meshes);
    for (std::size_t i = 0; i < scene.meshes.size(); ++i) scene.meshes[i].object_id = static_cast<std::uint32_t>(i + 1);
    const RenderScene world(scene);
    const CameraView camera = phone_camera(1, 8, 8);
    const Truth truth = trace_truth(world, camera);
    const Image motion = trace_motion(world, camera, scene, camera);
    EXPECT_NEAR(motion.at(3, 3, 0), 0, 1e-3);
    return std::pair(truth.depth_m.at(4, 4), truth.object_id.at(4, 4));
  };
  EXPECT_NEAR(depth({at(2, 0), at(1, 1)}).first, 2, 1e-4);
  EXPECT_EQ(depth({at(2, 0), at(1, 1)}).second, 1u);
  EXPECT_NEAR(depth({at(2, 0), at(1, 1), at(0.5f, 1)}).first, 2, 1e-4);
  EXPECT_NEAR(depth({at(2, 0), at(1, 2)}).first, 1, 1e-6);  // dark glass: what it reflects counts more
  EXPECT_NEAR(depth({at(2, 0), slab(1, 1.1f, 3)}).first, 1, 1e-6);
  EXPECT_TRUE(std::isinf(depth({at(1, 1), at(-1, 0)}).first));
}

// A path that is let into a ball of ior 3 is often reflected inside of it: it ends all the same.
TEST(GlassPaths, End) {
  Scene scene;
  scene.materials = {glass(glm::vec3(1), true), diffuse(0.5f)};
  scene.materials[0].layers->ior = 3;
  scene.meshes = {glass_ball({0, 0, 1}, 0.4f, 0), make_quad({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, 1)};
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(100)}};
  const double nits = seen(scene, 64, 2).y;
  EXPECT_GT(nits, 40);
  EXPECT_LT(nits, 101);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
