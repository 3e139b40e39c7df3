// Geometry at which ray tracers leak, darken or fail.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulator/render/paths.h"
#include "simulator/sampling/hash.h"
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
TEST(SlowRobustness, ClosedBoxesLetNothingIn) {
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

// The same of shared boxes: of rays that run straight at the edges between their triangles, where 1 in 30 would slip
// through without Embree's robust flag, none does.
TEST(Robustness, EdgesOfPlacedBoxesLetNothingThrough) {
  for (float half : {0.01f, 0.97f, 1.3e4f}) {
    const glm::mat3 turn(0.36f, 0.48f, -0.8f, -0.8f, 0.6f, 0, 0.48f, 0.64f, 0.6f), lean(1, 0, 0, 4, 1, 0, 0, 0, 1);
    for (const glm::mat3& axes : {glm::mat3(1), turn, lean}) {
      Scene scene;
      scene.materials = {diffuse(0.9f)};
      scene.meshes = {box(1, 16, glm::vec3(0))};
      Mesh& mesh = scene.meshes[0];
      const Placement instance{glm::mat4x3(half * axes[0], half * axes[1], half * axes[2], glm::vec3(0)), 1, false};
      mesh.placements = {instance};
      const Intersector intersector(scene);
      const glm::vec3 origin = half * glm::vec3(0.1f, -0.1f, 0.05f);
      for (std::uint64_t i = 0; i < 100000; ++i) {
        const glm::uvec3& t = mesh.triangles[i % mesh.triangles.size()];
        const float along = unit_float(static_cast<std::uint32_t>(hash(i) >> 32));
        const glm::vec3 end = glm::mix(mesh.positions[t.x], mesh.positions[t.z], along);
        ASSERT_TRUE(intersector.intersect(Ray{origin, instance.world_from_mesh * glm::vec4(end, 1) - origin}))
            << half << ' ' << i;
      }
    }
  }
}

/// `mesh` placed elsewhere, leaning by 4 to 1, which is almost as much as the glTF reader lets pass.
Mesh placed(Mesh mesh, float size, glm::vec3 origin) {
  mesh.placements = {{glm::mat4x3({size, 0, 0}, {4 * size, size, 0}, {0, 0, size}, origin), 1, false}};
  return mesh;
}

// One path of a packet meets an unlit surface; the others ended earlier and hold NaN, as what ended paths carry is
// never set. They must keep what they had gathered.
TEST(Robustness, UnlitSurfacesLeaveEndedPathsAlone) {
  Scene scene;
  scene.materials = {diffuse(1)};
  scene.materials[0].unlit = true;
  scene.unlit_white_nits = 100;
  scene.meshes = {make_quad({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}, 0)};
  alignas(64) Paths paths{};
  alignas(64) RayPacket rays{};
  for (int i = 0; i < kPacket; ++i) {
    const bool follows = i == 3;
    rays.direction_z[i] = 1;
    rays.far[i] = std::numeric_limits<float>::infinity();
    rays.mesh[i] = kNoMesh;
    paths.active[i] = follows ? -1 : 0;
    paths.pdf[i] = kCountedInFull;
    paths.straight_pdf[i] = -1;
    const float carried = follows ? 1 : std::numeric_limits<float>::quiet_NaN();
    paths.throughput.set(i, glm::vec3(carried));
    paths.unlit_throughput.set(i, glm::vec3(carried));
    paths.radiance.set(i, glm::vec3(7));
  }
  trace_paths(RenderScene(scene), {}, {0, ~0u, 1}, 0, rays, paths);
  for (int i = 0; i < kPacket; ++i) EXPECT_EQ(paths.radiance.at(i), glm::vec3(i == 3 ? 107 : 7)) << i;
}

// A sheet that fills half the sky reflects albedo times the sky's other half, from millimetres to tens of kilometres:
// nothing that a surface throws back is shadowed by itself. Negative: a shared sheet that is placed there.
TEST(SlowRobustness, WallsOfAllSizesDoNotShadowThemselves) {
  for (float signed_size : {1e-3f, 1e-2f, 1.0f, 1e2f, 1e4f, -1e-3f, -1.0f, -1e4f}) {
    const float size = std::abs(signed_size);
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {signed_size > 0
                        ? make_quad({-5 * size, -5 * size, size}, {10 * size, 0, 0}, {0, 10 * size, 0}, 0)
                        : placed(make_quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0), 40 * size, {20 * size, 0, size})};
    scene.environment = even_sky(100);
    const auto [low, high] = range_of(scene, phone_camera(size > 0.01f ? size : 0.01, 24, 24));
    // the light sampler's table is flat within a cell of 11 degrees, where cosines are not: a sample's worth spreads by
    // a fifth, the mean of 64 by 2.5 % of 50 at worst; over 576 photosites the extremes lie three of these away
    EXPECT_NEAR(low, 50, 4) << signed_size;
    EXPECT_NEAR(high, 50, 4) << signed_size;
  }
}

// A slope 2 km long that ends a centimetre in front of the camera: what rounding does to rays there goes by how far the
// mesh's own origin is, 900 m, not by where the ray meets it.
TEST(Robustness, PlacementsFarFromTheirMiddleDoNotShadowThemselves) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  Mesh slope = make_quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0);
  const glm::vec3 along = glm::normalize(glm::vec3(0.8f, 0.1f, 0.5f)), up = glm::normalize(glm::vec3(0.5f, 0, -0.8f));
  const glm::vec3 across = glm::cross(up, along);
  slope.placements = {
      {glm::mat4x3(1e3f * along, 1e3f * across, up, glm::vec3(0, 0, 0.01f) + 900.0f * along), 1, false}};
  scene.meshes = {slope};
  scene.environment = even_sky(100);
  const auto [low, high] = range_of(scene, phone_camera(0.01, 24, 24));
  EXPECT_NEAR(low, 50, 4);
  EXPECT_NEAR(high, 50, 4);
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

// Two coincident sheets look like one, whichever of them a ray meets.
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

// Triangles a meter long and a micrometre wide, one without area, sheets through the lens's own plane and through its
// pupil: numbers come out, and no more light than the sky has.
TEST(SlowRobustness, SliversAndSheetsThroughTheLensStayFinite) {
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
