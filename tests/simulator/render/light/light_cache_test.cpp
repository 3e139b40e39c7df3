// Light kept on surfaces against light sampled anew by every path.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <memory>

#include "simulator/render/shading/radiometry.h"
#include "simulator/render/views.h"
#include "simulator/sampling/mosaic.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr LightCacheOptions kNone{.light_spacing_px = 0};

/// A room with a window onto a bright sky: a floor, walls, a ball-like box on the floor, and a lamp.
Scene room() {
  Scene scene;
  scene.materials = {diffuse(0.6f), glowing(4000), diffuse(0.3f)};
  scene.materials[2].roughness = 0.4f;
  scene.meshes = {make_quad({-1, 0.5f, 0.6f}, {2, 0, 0}, {0, 0, 2}, 0),
                  make_quad({-1, -1, 2}, {2, 0, 0}, {0, 1.5f, 0}, 0),
                  make_quad({-0.3f, -0.9f, 1.2f}, {0.5f, 0, 0}, {0, 0, 0.3f}, 1),
                  make_quad({-0.2f, 0, 1.2f}, {0.4f, 0, 0.2f}, {0, 0.49f, 0}, 2)};
  scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(200))};
  scene.environment.radiance_nits[10] = glm::vec3(3000, 2500, 2000);
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.direction = glm::normalize(glm::vec3(0.4f, 1, 0.3f));
  sun.intensity = glm::vec3(900);
  scene.lights = {sun};
  return scene;
}

struct Difference {
  double rms = 0, mean = 0;  ///< over the mean picture
};

Difference difference(const Image& a, const Image& b) {
  double squares = 0, sum = 0, all = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const double d = static_cast<double>(a.data[i]) - b.data[i];
    squares += d * d, sum += d, all += b.data[i];
  }
  const auto count = static_cast<double>(a.data.size());
  return {std::sqrt(squares / count) / (all / count), sum / all};
}

Image picture(const Scene& scene, const LightCacheOptions& cache, int samples, int bounces, int side_px = 48) {
  return undivided(render_views(RenderScene(scene, cache), phone_camera(1.3, side_px, side_px), {samples, bounces, 5}));
}

// With many samples both give the same picture: direct light, and light of three reflections. RMS, measured: .0044 and
// .0065, with the noise of the sampled picture, of 1024 light samples and of what the lamp leaves to each path.
TEST(SlowLightCache, GivesThePictureOfPlainPathTracing) {
  for (const bool lamp : {true, false}) {
    Scene scene = room();
    if (!lamp) scene.materials[1] = diffuse(0.6f);
    for (int bounces : {0, 3}) {
      const Image cached = picture(scene, {.light_spacing_px = 1, .light_samples = 1024}, 256, bounces, 32);
      const Image sampled = picture(scene, kNone, 4096, bounces, 32);
      const Difference d = difference(cached, sampled);
      EXPECT_LT(std::abs(d.mean), 0.003) << bounces << " reflections, lamp " << lamp;
      EXPECT_LT(d.rms, 0.009) << bounces << " reflections, lamp " << lamp;
    }
  }
}

// A lamp 8 mm before a wall, just out of view: its light falls off within the 15 mm of wall that are seen. Linear
// interpolation errs by the square of the spacing: by a sixteenth at a quarter of it, up to noise.
TEST(SlowLightCache, DenserPointsAreNearer) {
  Scene scene;
  scene.materials = {diffuse(0.6f), glowing(4000)};
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0),
                  make_quad({0.012f, -0.001f, 0.992f}, {0, 0.002f, 0}, {0.002f, 0, 0}, 1)};
  const Image sampled = picture(scene, kNone, 4096, 0);
  const auto error = [&](double spacing_px) {
    return difference(picture(scene, {.light_spacing_px = spacing_px, .light_samples = 1024}, 256, 0), sampled).rms;
  };
  EXPECT_LT(error(4), 0.3 * error(16));
}

// It is there to save samples: with 16 of them the error is a fraction of that of plain path tracing.
TEST(SlowLightCache, TakesTheNoiseOfLightOffTheSamples) {
  const Image truth = picture(room(), kNone, 4096, 0);
  const double cached = difference(picture(room(), {}, 16, 0), truth).rms;
  const double sampled = difference(picture(room(), kNone, 16, 0), truth).rms;
  EXPECT_LT(cached, 0.5 * sampled);
}

// Bytes depend neither on threads, nor on what was rendered before, nor on whether the table is full.
TEST(SlowLightCache, BytesDependOnTheSceneAlone) {
  const Scene scene = room();
  const CameraView camera = phone_camera(1.3, 48, 48);
  const auto render = [&](const RenderScene& world) { return render_views(world, camera, {16, 1, 5}).left.data; };
  const std::vector<float> once = render(RenderScene(scene));
  {
    const RenderScene used(scene);
    render_views(used, phone_camera(0.7, 32, 32), {16, 1, 9});
    EXPECT_EQ(render(used), once) << "after another camera";
    EXPECT_EQ(render(used), once) << "again";
  }
  {
    const RenderScene used(scene);
    render_views(used, camera, {16, 3, 5});
    EXPECT_EQ(render(used), once) << "after more reflections";
  }
  const RenderScene full(scene, {.light_memory_mb = 0.004});
  EXPECT_EQ(render(full), once) << "in a table of one page";
  EXPECT_GT(full.light_cache->table.turned_away(), 0u);
  for (int threads : {1, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(render(RenderScene(scene)), once) << threads << " threads";
  }
}

/// Eight sides around an upright axis, whose normals make it look round.
Mesh make_post(glm::vec3 foot, float radius_m, float height_m, int material) {
  Mesh mesh = make_quad(foot, {1, 0, 0}, {0, 1, 0}, material);
  mesh.positions.clear(), mesh.uv0.clear(), mesh.normals.clear(), mesh.triangles.clear();
  for (unsigned side = 0; side <= 8; ++side) {
    const float angle = static_cast<float>(side) * kPi / 4;
    for (const float y : {0.0f, height_m}) {
      mesh.normals.emplace_back(std::cos(angle), 0, std::sin(angle));
      mesh.positions.push_back(foot + radius_m * mesh.normals.back() + glm::vec3(0, y, 0));
      mesh.uv0.emplace_back(0, 0);
    }
    if (side == 8) break;
    const unsigned a = 2 * side;
    mesh.triangles.push_back({a, a + 1, a + 2});
    mesh.triangles.push_back({a + 2, a + 1, a + 3});
  }
  return mesh;
}

// Points of reflected light, 5 mm apart, are too far apart for normals that turn by a quarter circle within 11 mm, even
// where light comes from afar, as from this sunlit wall. Without closer points the error is .056 and not .013.
TEST(LightCache, FollowsSurfacesThatTurn) {
  Scene scene;
  scene.materials = {diffuse(0.8f)};
  scene.meshes = {make_quad({-1, -2, -1}, {0, 0, 4}, {0, 4, 0}, 0), make_post({0, -0.1f, 1.2f}, 0.007f, 0.2f, 0)};
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.direction = {-1, 0, 0};
  sun.intensity = glm::vec3(900);
  scene.lights = {sun};
  const Image cached = picture(scene, {.light_samples = 1024}, 256, 1, 32);
  const Image sampled = picture(scene, kNone, 1024, 1, 32);
  EXPECT_LT(difference(cached, sampled).rms, 0.02);
}

// The same for light of the sky, from points that are asked for as far apart: .073, and .015 with closer ones.
TEST(LightCache, FollowsSurfacesThatTurnInDirectLight) {
  Scene scene;
  scene.materials = {diffuse(0.8f)};
  scene.meshes = {make_post({0, -0.1f, 1.2f}, 0.007f, 0.2f, 0)};
  scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(0))};
  for (int x = 0; x < 4; ++x)
    scene.environment.radiance_nits[8 + x] = scene.environment.radiance_nits[16 + x] = glm::vec3(1000);
  const Image cached = picture(scene, {.light_spacing_px = 16, .light_samples = 1024}, 256, 0, 32);
  const Image sampled = picture(scene, kNone, 1024, 0, 32);
  EXPECT_LT(difference(cached, sampled).rms, 0.02);
}

/// A square cut into n x n smaller ones.
Mesh make_grid(glm::vec3 corner, glm::vec3 a, glm::vec3 b, int n, int material) {
  Mesh mesh = make_quad(corner, a, b, material);
  mesh.positions.clear(), mesh.uv0.clear(), mesh.triangles.clear();
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      const glm::vec2 uv = glm::vec2(x, y) / static_cast<float>(n);
      mesh.positions.push_back(corner + uv.x * a + uv.y * b);
      mesh.uv0.push_back(uv);
      if (x == n || y == n) continue;
      const unsigned i = y * (n + 1) + x, below = i + n + 1;
      mesh.triangles.push_back({i, i + 1, below + 1});
      mesh.triangles.push_back({i, below + 1, below});
    }
  }
  return mesh;
}

// Points of reflected light take many paths each. On triangles smaller than the points would be apart there are more
// points than samples that ask for them, so that all light is sampled there, as without points; direct light is not.
// The wall fills the picture, 15 mm; four photosites see 1.3 mm of it, whatever the spacing.
TEST(LightCache, SamplesReflectedLightOnSmallTriangles) {
  for (const int pieces : {64, 4}) {  // of .6 mm, of 10 mm
    Scene scene = room();
    scene.meshes = {make_quad({-1, 0.5f, -1}, {2, 0, 0}, {0, 0, 2}, 0),
                    make_grid({-0.02f, -0.02f, 1}, {0.04f, 0, 0}, {0, 0.04f, 0}, pieces, 0)};
    for (const int bounces : {0, 1}) {
      const Image sampled = picture(scene, kNone, 16, bounces);
      for (const double spacing_px : {1, 4}) {
        const bool is_sampled = picture(scene, {.light_spacing_px = spacing_px}, 16, bounces).data == sampled.data;
        EXPECT_EQ(is_sampled, bounces > 0 && pieces == 64)
            << pieces << " pieces, " << bounces << " reflections, " << spacing_px << " px";
      }
    }
  }
}

/// A white wall, 24 photosites of 1 mm in the picture, on which a sun from the left gives 800 lux.
Scene wall_in_the_sun() {
  Scene scene;
  scene.materials = {diffuse(1)};
  scene.meshes = {make_quad({-1, 1, 1}, {2, 0, 0}, {0, -2, 0}, 0)};
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.direction = {0.6f, 0, 0.8f};
  sun.intensity = glm::vec3(1000);
  scene.lights = {sun};
  return scene;
}

constexpr LightCacheOptions kFarApart{.light_spacing_px = 16};
constexpr int kWallSide = 24;

/// Over that of the wall in the sun, summed over a row of photosites: 24 where all of it is lit.
double light_of_a_row(const Scene& scene, const LightCacheOptions& cache, int bounces = 0) {
  constexpr int kSamples = 256;
  const CameraView camera = phone_camera(1, kWallSide, kWallSide, {}, 4.442e-6);
  const Image image = undivided(render_views(RenderScene(scene, cache), camera, {kSamples, bounces, 5}));
  double sum = 0;
  for (int y = 0; y < kWallSide; ++y) {
    for (int x = 0; x < kWallSide; ++x) sum += image.at(x, y) / (800 / M_PI);
  }
  return sum / kWallSide;
}

/// What casts a shadow on the wall from `left` to `right`, meters, and is out of the picture.
Mesh blocker(float left, float right) {
  const float shift = 0.5f * 0.6f / 0.8f;
  return make_quad({left - shift, 1, 0.5f}, {right - left, 0, 0}, {0, -2, 0}, 0);
}

constexpr float kThin = 0.25e-3f;  // a quarter of a photosite
// Of 256 samples in a photosite 64 meet a thin shadow, and 16 of these check, for 4 each: a standard error of sqrt(12)
// * 4 / 256 (binomial) in each of 24 rows, .011 in all. Four of them:
constexpr double kNoiseOfChecks = 0.044;
// Where every path asks: sqrt(48) / 256 in each row, .0055 in all. Nearly four of them:
constexpr double kNoiseOfPaths = 0.02;

// A shadow a quarter of a photosite wide, between points 16 photosites apart, all of which are lit.
TEST(LightCache, KeepsShadowsThatLieBetweenPoints) {
  const Scene scene = wall_in_the_sun();
  EXPECT_NEAR(light_of_a_row(scene, kFarApart), kWallSide, 1e-3);
  for (const float at : {-0.0031f, 0.0032f, 0.0043f}) {
    Scene behind_wire = scene;
    behind_wire.meshes.push_back(blocker(at, at + kThin));
    EXPECT_NEAR(light_of_a_row(behind_wire, kNone), kWallSide - 0.25, kNoiseOfPaths) << at;
    EXPECT_NEAR(light_of_a_row(behind_wire, kFarApart), kWallSide - 0.25, kNoiseOfChecks) << at;
  }
}

TEST(LightCache, FindsSunThatFallsBetweenPoints) {
  Scene behind_slit = wall_in_the_sun();
  behind_slit.meshes.push_back(blocker(-0.1f, 0.0032f));
  behind_slit.meshes.push_back(blocker(0.0032f + kThin, 0.1f));
  EXPECT_NEAR(light_of_a_row(behind_slit, kNone), 0.25, kNoiseOfPaths);
  EXPECT_NEAR(light_of_a_row(behind_slit, kFarApart), 0.25, kNoiseOfChecks);
}

// A board behind the lamp, seen from the wall, hides nothing: the same paths find the same light.
TEST(LightCache, ChecksEndAtTheirLamp) {
  Scene scene = wall_in_the_sun();
  scene.lights[0].kind = PunctualLight::Kind::point;
  scene.lights[0].position = {-0.3f, 0, 0.6f};
  const double alone = light_of_a_row(scene, kFarApart);
  EXPECT_GT(alone, kWallSide);
  scene.meshes.push_back(make_quad({-1, 1, 0.2f}, {0.6f, 0, 0}, {0, -2, 0}, 0));
  EXPECT_DOUBLE_EQ(light_of_a_row(scene, kFarApart), alone);
}

// The check counts for diffuse light alone; what a gloss adds is sampled by each path.
TEST(LightCache, KeepsThinShadowsOnGlossyWalls) {
  Scene scene = wall_in_the_sun();
  scene.materials[0].roughness = 0.4f;
  scene.meshes.push_back(blocker(0.0032f, 0.0032f + kThin));
  EXPECT_NEAR(light_of_a_row(scene, kFarApart), light_of_a_row(scene, kNone), kNoiseOfChecks + kNoiseOfPaths);
}

// Seen in a mirror that reflects half of the light: a wall behind the camera, 3 m away along the ray, where the shadow
// is three times as wide.
TEST(LightCache, KeepsThinShadowsInMirrors) {
  Scene scene = wall_in_the_sun();
  scene.materials.push_back(diffuse(0.5f));
  scene.materials[1].metallic = 1;
  scene.materials[1].roughness = 0;
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 1), make_quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 0),
                  make_quad({0.0062f - 0.375f, 1, -0.5f}, {3 * kThin, 0, 0}, {0, -2, 0}, 0)};
  scene.lights[0].direction.z *= -1;
  const double lit = 0.5 * kWallSide, missing = 0.5 * 0.25;
  EXPECT_NEAR(light_of_a_row(scene, kNone, 1), lit - missing, 0.5 * kNoiseOfPaths);
  EXPECT_NEAR(light_of_a_row(scene, kFarApart, 1), lit - missing, 0.5 * kNoiseOfChecks);
}

// Light of a lamp 8 cm away is no straight line between points: without checks it is off by .39 of a column.
TEST(LightCache, KnowsANearLampBetweenPoints) {
  Scene scene = wall_in_the_sun();
  scene.lights[0].kind = PunctualLight::Kind::point;
  scene.lights[0].position = {0.005f, 0.003f, 0.92f};
  scene.lights[0].intensity = glm::vec3(800 * 0.08f * 0.08f);
  EXPECT_NEAR(light_of_a_row(scene, kFarApart), light_of_a_row(scene, kNone), 0.01);
}

// One of several lamps is not all of them: where there are more, points are trusted.
TEST(LightCache, DoesNotTakeOneLampForAll) {
  Scene scene = wall_in_the_sun();
  scene.lights.push_back(scene.lights[0]);
  for (PunctualLight& light : scene.lights) light.intensity *= 0.5f;
  EXPECT_NEAR(light_of_a_row(scene, kFarApart), kWallSide, 1e-3);
}

// What is set aside comes back with its points, and takes no more memory than one cache may.
TEST(LightCache, IsSetAsideWithinItsMemory) {
  const Scene scene = room();
  const CameraView camera = phone_camera(1.3, 16, 16);
  const auto with_scrambles = [&](const LightCacheOptions& options, int count) {
    auto world = std::make_unique<RenderScene>(scene, options);
    for (int scramble = 0; scramble < count; ++scramble) {
      use_light(*world, options, scramble);
      EXPECT_EQ(world->light_cache->table.points(), 0u);
      render_views(*world, camera, {16, 0, 5});
    }
    return world;
  };
  const auto roomy = with_scrambles({}, 3);
  EXPECT_EQ(roomy->spare_light.size(), 2u);
  const std::uint64_t points = roomy->spare_light.front()->table.points();
  EXPECT_GT(points, 0u);
  use_light(*roomy, {}, 0);
  EXPECT_EQ(roomy->light_cache->table.points(), points);
  EXPECT_EQ(roomy->spare_light.size(), 2u);
  EXPECT_EQ(roomy->spare_light.back()->scramble, 2u);

  const auto narrow = with_scrambles({.light_memory_mb = 0.004}, 5);  // a page each, and a page for the spare
  ASSERT_EQ(narrow->spare_light.size(), 1u);
  EXPECT_EQ(narrow->spare_light.front()->scramble, 3u);
  EXPECT_EQ(with_scrambles({}, 30)->spare_light.size(), 18u);
}

// A mirror shows lamp and sky at the default of no reflections, exactly as bright as they are.
TEST(LightCache, MirrorsShowLights) {
  Scene scene;
  scene.materials = {diffuse(1), glowing(300)};
  scene.materials[0].metallic = 1;
  scene.materials[0].roughness = 0;
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0), make_quad({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}, 1)};
  const Image image = undivided(render_views(RenderScene(scene), phone_camera(1, 8, 8), {64, 0, 5}));
  for (float value : image.data) EXPECT_NEAR(value, 300, 6);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
