#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "capture/error.h"
#include "datasets/plan/plan.h"
#include "datasets/render/render.h"
#include "scenes/gltf/glb.h"
#include "scenes/shapes/solids.h"
#include "tests/datasets/small_recipe.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;

/// Closed boxes of side 1 around these middles.
void write_boxes(const std::string& path, const std::vector<glm::vec3>& middles) {
  scenes::Glb glb;
  scenes::Mesh mesh;
  for (const glm::vec3& middle : middles) scenes::add_solid_box(mesh, middle, glm::vec3(0.5f));
  glb.add_node("boxes", mesh, glb.add_material(-1, glm::vec3(0.5f), false));
  glb.write(path);
}

json around(const std::string& glb, double distance, double elevation_deg, double azimuth_deg) {
  json recipe = testing::small_recipe(1);
  recipe["scenes"] = {{{"file", glb}}};
  recipe["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {100, 100, 100}}}}};
  recipe["relations"] = {
      {"camera_shell", {{"distance", distance}, {"elevation_deg", elevation_deg}, {"azimuth_deg", azimuth_deg}}}};
  return recipe;
}

Capture render(const json& recipe) {
  std::unique_ptr<simulator::ReadyScene> ready;
  return render_line(make_plan(read_recipe(recipe, "r.json")).lines.front(), "", ready);
}

glm::vec3 position_of(const Capture& capture) {
  const json scene = json::parse(capture.provenance.scene);
  const json& p = scene["camera"]["position_m"];
  return {p[0].get<float>(), p[1].get<float>(), p[2].get<float>()};
}

TEST(CameraShell, LiesAroundTheMiddleOfTheBox) {
  const TemporaryFolder folder;
  const glm::vec3 middle(1, 2, 3);
  write_boxes(folder / "box.glb", {middle});
  const glm::vec3 away = position_of(render(around(folder / "box.glb", 2, 30, 90))) - middle;
  const float distance = 2 * std::sqrt(0.75f);  // of half the diagonal
  EXPECT_NEAR(glm::length(away), distance, 1e-4);
  EXPECT_NEAR(away.y, distance * 0.5f, 1e-4);
  EXPECT_NEAR(away.x, distance * std::sqrt(0.75f), 1e-4);
  EXPECT_NEAR(away.z, 0, 1e-4);
}

TEST(CameraShell, ScalesWithTheModel) {
  const TemporaryFolder folder;
  write_boxes(folder / "box.glb", {{1, 2, 3}});
  json recipe = around(folder / "box.glb", 2, 0, 0);
  recipe["relations"]["model_size_m"] = 2.5;
  const Capture capture = render(recipe);
  const Image& depth = capture.truth->depth_m;
  // from the shell to the face of the box, whose side is 2.5 m
  EXPECT_NEAR(depth.at(depth.width / 2, depth.height / 2), 2.5 * (2 * std::sqrt(0.75) - 0.5), 1e-4);
}

TEST(CameraShell, IsNeverInsideOfAnything) {
  const TemporaryFolder folder;
  write_boxes(folder / "box.glb", {{0, 0, 0}});
  EXPECT_EQ(message_of<InputError>([&] { render(around(folder / "box.glb", 0.3, 0, 0)); }),
            (folder / "box.glb") + ": camera_shell: no free place was found around the scene");

  // the shell's first place is the middle of one of these
  write_boxes(folder / "two.glb", {{0, 0, 2}, {0, 0, -2}});
  const double radius = 0.5 * std::sqrt(1 + 1 + 25);
  const glm::vec3 at = position_of(render(around(folder / "two.glb", 2 / radius, 0, 0)));
  EXPECT_NEAR(glm::length(at), 2, 1e-4);
  for (const float z : {2.0f, -2.0f}) {
    const glm::vec3 off = glm::abs(at - glm::vec3(0, 0, z));
    EXPECT_GT(std::max({off.x, off.y, off.z}), 0.5f);
  }
}

TEST(Relations, SayWhereNothingIsSeen) {
  const TemporaryFolder folder;
  write_boxes(folder / "box.glb", {{0, 0, 0}});
  json recipe = around(folder / "box.glb", 2, 0, 0);
  recipe["relations"] = {{"focus", "surface"}};
  recipe["set"]["camera.position_m"] = {0, 0, 5};
  recipe["set"]["camera.look_at_m"] = {0, 0, 9};
  EXPECT_EQ(message_of<InputError>([&] { render(recipe); }),
            (folder / "box.glb") + ": focus_at: the camera sees no surface");
}

}  // namespace
}  // namespace dualpixel::datasets
