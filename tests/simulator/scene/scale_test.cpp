#include "simulator/scene/scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator {
namespace {

using testing::make_quad;

TEST(ScaleTo, LongestSideAndLightAtASurface) {
  Scene scene;
  scene.meshes = {make_quad({1, 2, 3}, {4, 0, 0}, {0, 2, 0}, 0), make_quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0)};
  // the second mesh appears once, from (-3, 0, 0) to (-2, 1, 0): the box is 8 wide in all
  scene.meshes[1].placements = {
      {glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(-3, 0, 0)), 1, false}};
  scene.lights = {{PunctualLight::Kind::point, glm::vec3(8), {0, 4, 0}},
                  {PunctualLight::Kind::directional, glm::vec3(8)}};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  scene.cameras[0].world_from_node[3] = {0, 0, 8, 1};
  scale_to(scene, 2);  // a quarter
  EXPECT_EQ(scene.meshes[0].positions[2], glm::vec3(1.25f, 1, 0.75f));
  EXPECT_EQ(scene.meshes[1].positions[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(scene.meshes[1].placements[0].world_from_mesh * glm::vec4(1, 1, 0, 1), glm::vec3(-0.5f, 0.25f, 0));
  EXPECT_EQ(scene.lights[0].position, glm::vec3(0, 1, 0));
  EXPECT_EQ(scene.lights[0].intensity, glm::vec3(0.5f));  // a quarter as far: the same lux
  EXPECT_EQ(scene.lights[1].intensity, glm::vec3(8));
  EXPECT_EQ(scene.cameras[0].world_from_node[3], glm::vec4(0, 0, 2, 1));
}

// What no triangle uses is not there, and a turned thing is as long as it is.
TEST(LongestSide, CountsWhatIsSeen) {
  Scene scene;
  scene.meshes = {make_quad({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 0)};
  scene.meshes[0].positions.emplace_back(100, 0, 0);
  EXPECT_EQ(longest_side(scene), 2);
  const float c = std::sqrt(0.5f);
  scene.meshes[0].placements = {
      {glm::mat4x3(glm::vec3(c, c, 0), glm::vec3(-c, c, 0), glm::vec3(0, 0, 1), glm::vec3(0)), 1, false}};
  EXPECT_NEAR(longest_side(scene), std::sqrt(8), 1e-6);
}

}  // namespace
}  // namespace dualpixel::simulator
