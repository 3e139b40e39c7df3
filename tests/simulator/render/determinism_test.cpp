#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "simulator/render/truth.h"
#include "simulator/sensor/sensor.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

struct Result {
  Views views;
  Frame frame;
};

Result run(int threads, std::uint64_t seed) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Scene scene;
  scene.materials = {diffuse(0.7f), glowing(300)};
  scene.meshes = {make_quad({-1, -1, 1.5f}, {2, 0, 0.5f}, {0, 2, 0}, 0),
                  make_quad({-0.1f, -0.1f, 0.6f}, {0.05f, 0, 0}, {0, 0.2f, 0}, 1)};
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(900)}};
  const CameraView camera = phone_camera(0.8, 96, 64);
  Result result;
  result.views = render_views(RenderScene(scene), camera, {16, 1, seed});
  SensorOptions sensor;
  sensor.width_px = 96;
  sensor.height_px = 64;
  const Image electrons = expected_electrons(result.views.left, result.views.right, sensor, {0.01, 100}, 0.2);
  result.frame = expose(electrons, sensor, {0.01, 100}, seed);
  return result;
}

TEST(Determinism, SameBytesForOneTwoAndEightThreads) {
  const Result one = run(1, 5);
  for (int threads : {2, 8}) {
    const Result other = run(threads, 5);
    EXPECT_EQ(one.views.left.data, other.views.left.data);
    EXPECT_EQ(one.views.right.data, other.views.right.data);
    EXPECT_EQ(one.frame.mosaic.data, other.frame.mosaic.data);
    EXPECT_EQ(one.frame.left.data, other.frame.left.data);
    EXPECT_EQ(one.frame.right.data, other.frame.right.data);
  }
}

TEST(Determinism, SeedDecides) {
  EXPECT_EQ(run(2, 5).frame.mosaic.data, run(2, 5).frame.mosaic.data);
  EXPECT_NE(run(2, 5).frame.mosaic.data, run(2, 6).frame.mosaic.data);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
