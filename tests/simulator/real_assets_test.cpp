// Real glTF files that we did not make are imported and rendered: something is seen, nothing is infinite. (The one that
// is missing here, DenseSphere.glb, requires Draco compression and is refused by that name: see
// tests/simulator/scene/gltf/assets_test.cpp.)
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "simulator/render/intersector.h"
#include "simulator/scene/gltf/gltf.h"
#include "simulator/simulate.h"
#include "tests/shared_folder.h"

namespace dualpixel::simulator {
namespace {

std::filesystem::path shared_gltf() { return shared_folder() / "data/gltf"; }

class RealAsset : public ::testing::TestWithParam<const char*> {};

TEST_P(RealAsset, ImportsAndRenders) {
  const std::filesystem::path file = shared_gltf() / GetParam();
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << file << " is not there: it needs the shared folder of real assets";
  const Scene geometry = read_gltf(file.string());
  const auto [low, high] = Intersector(geometry).bounds();
  const glm::vec3 centre = 0.5f * (low + high);
  const float size = glm::length(high - low);
  const glm::vec3 eye = centre + glm::vec3(0.6f, 0.5f, 1.2f) * size;
  const nlohmann::json document = {{"version", 1},
                                   {"gltf", file.string()},
                                   {"camera",
                                    {{"position_m", {eye.x, eye.y, eye.z}},
                                     {"look_at_m", {centre.x, centre.y, centre.z}},
                                     {"focus_distance_m", glm::length(eye - centre)}}},
                                   {"sensor", {{"width_px", 64}, {"height_px", 48}, {"pixel_pitch_um", 58.8}}},
                                   {"environment", {{"model", "constant"}, {"nits", {1000, 1000, 1000}}}},
                                   {"burst", {{"frames", 1}}}};
  const Simulation s = read_simulation(document, "scene.json");
  const Scene scene = load_scene(s);
  const Capture capture = simulate(s, scene);
  double hit = 0;
  for (float v : capture.truth->valid.data) hit += v;
  EXPECT_GT(hit, 0.03 * 64 * 48);
  EXPECT_LT(hit, 64 * 48);
  for (float v : capture.truth->all_in_focus.data) ASSERT_TRUE(std::isfinite(v) && v >= 0);
}

INSTANTIATE_TEST_SUITE_P(Shared, RealAsset,
                         ::testing::Values("gltf-transform/Box.glb", "gltf-transform/BoxTextured/BoxTextured.gltf",
                                           "gltf-transform/BoxVertexColors.glb", "gltf-transform/ShapeCollection.glb",
                                           "tinygltf/Cube/Cube.gltf",
                                           "tinygltf/Cube-texture-ext/Cube-textransform.gltf",
                                           "tinygltf/CubeImageUriSpaces/CubeImageUriSpaces.gltf",
                                           "tinygltf/CubeImageUriSpaces/CubeImageUriMultipleSpaces.gltf",
                                           "tinygltf/SparseMorphTargets-issue280/singleBlendshapeCube_sparse.glb",
                                           "tinygltf/box01.glb"));

}  // namespace
}  // namespace dualpixel::simulator
