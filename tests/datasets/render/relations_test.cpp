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
  return render_line(make_plan(read_recipe(recipe, "r.json")).lines.front(), "", ready).capture;
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

/// Mean and standard error of what 48 x 36 photosites, which the meter reads, show of the undivided views.
std::pair<double, double> green_mean(const Capture& capture) {
  const Image left = normalized(capture.frames[0].left, capture.exposure);
  const Image right = normalized(capture.frames[0].right, capture.exposure);
  double sum = 0, square = 0;
  const auto n = static_cast<double>(left.data.size());
  for (std::size_t i = 0; i < left.data.size(); ++i) {
    const double signal = left.data[i] + right.data[i];
    sum += signal / n;
    square += signal * signal / n;
  }
  return {sum, std::sqrt((square - sum * sum) / (48 * 36))};
}

// A green filter that sees mostly red, before red light.
TEST(SlowRelations, MeterWhatTheGreenFilterSees) {
  const TemporaryFolder folder;
  write_boxes(folder / "box.glb", {{0, 0, 0}});
  json recipe = around(folder / "box.glb", 2, 20, 30);
  recipe["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {300, 60, 60}}}}};
  recipe["set"]["sensor.color_matrix"] = {1, 0, 0, 0.8, 0.2, 0, 0, 0, 1};
  recipe["relations"]["exposure_mean"] = 0.2;
  const auto [mean, error] = green_mean(render(recipe));
  EXPECT_LT(error, 0.005);
  EXPECT_NEAR(mean, 0.2, 5 * error);
}

/// Of a box under an even sky, with time and gain for a mean; `away` radii from it.
RenderedSample exposed(const std::string& glb, double nits, double mean, double away) {
  json recipe = around(glb, away, 20, 30);
  recipe["set"].erase("exposure.iso");
  recipe["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {nits, nits, nits}}}}};
  recipe["relations"]["exposure_mean"] = mean;
  std::unique_ptr<simulator::ReadyScene> ready;
  return render_line(make_plan(read_recipe(recipe, "r.json")).lines.front(), "", ready);
}

// A sky that is darker by a factor asks for as much more light. The longest is 1/12 s at ISO 12800.
TEST(SlowRelations, SayWhichExposureTheyMiss) {
  const TemporaryFolder folder;
  write_boxes(folder / "box.glb", {{0, 0, 0}});
  const RenderedSample bright = exposed(folder / "box.glb", 100, 0.2, 2);
  EXPECT_FALSE(bright.missed_exposure);
  const Exposure& exposure = bright.capture.exposure;
  const RenderedSample dark = exposed(folder / "box.glb", 1e-4, 0.2, 2);
  ASSERT_TRUE(dark.missed_exposure);
  // time and gain keep four digits each
  const double expected_s = 1e6 * exposure.time_s * exposure.iso / 100;
  EXPECT_NEAR(dark.missed_exposure->asked_s, expected_s, 2e-3 * expected_s);
  EXPECT_NEAR(dark.missed_exposure->limit_s, 128.0 / 12, 1e-9);
  EXPECT_NEAR(dark.missed_exposure->taken_s, 128.0 / 12, 128.0 / 12 * 1e-3);
  EXPECT_DOUBLE_EQ(dark.missed_exposure->taken_s, dark.capture.exposure.time_s * dark.capture.exposure.iso / 100);
  const RenderedSample glaring = exposed(folder / "box.glb", 1e9, 0.2, 2);
  ASSERT_TRUE(glaring.missed_exposure);
  EXPECT_DOUBLE_EQ(glaring.missed_exposure->limit_s, 1e-6);
}

// A glowing box in a black room fills less than nine tenths of the picture: clipped as it may be, the mean is less.
TEST(Relations, SayThatNoExposureReachesTheMean) {
  const TemporaryFolder folder;
  scenes::Glb glb;
  scenes::Mesh mesh;
  scenes::add_solid_box(mesh, glm::vec3(0), glm::vec3(0.5f));
  glb.add_node("box", mesh, glb.add_material(-1, glm::vec3(0.5f), true));
  glb.write(folder / "glows.glb");
  json recipe = around(folder / "glows.glb", 6, 20, 30);
  recipe["set"].erase("environment");
  recipe["set"]["unlit_white_nits"] = 500;
  recipe["set"].erase("exposure.iso");
  recipe["relations"]["exposure_mean"] = 0.9;
  std::unique_ptr<simulator::ReadyScene> ready;
  const RenderedSample sample = render_line(make_plan(read_recipe(recipe, "r.json")).lines.front(), "", ready);
  ASSERT_TRUE(sample.missed_exposure);
  EXPECT_TRUE(std::isinf(sample.missed_exposure->asked_s));
  EXPECT_EQ(scenes::to_json(*sample.missed_exposure)["asked_s"], "inf");
  EXPECT_EQ(sample.missed_exposure->limit_s, sample.missed_exposure->taken_s);
}

// Below ISO 100 the wells are full before the digital range is: at ISO 50 they hold half of it.
TEST(SlowRelations, MeterToTheWellsBelowIso100) {
  const TemporaryFolder folder;
  write_boxes(folder / "box.glb", {{0, 0, 0}});
  json recipe = around(folder / "box.glb", 2, 20, 30);
  recipe["set"]["exposure.iso"] = 50;
  const auto render_mean = [&](double mean) {
    recipe["relations"]["exposure_mean"] = mean;
    std::unique_ptr<simulator::ReadyScene> ready;
    return render_line(make_plan(read_recipe(recipe, "r.json")).lines.front(), "", ready);
  };
  const RenderedSample reached = render_mean(0.47);  // the sky is clipped
  EXPECT_FALSE(reached.missed_exposure);
  const auto [mean, error] = green_mean(reached.capture);
  EXPECT_LT(error, 0.005);
  EXPECT_NEAR(mean, 0.47, 5 * error);
  const RenderedSample missed = render_mean(0.6);
  ASSERT_TRUE(missed.missed_exposure);
  EXPECT_TRUE(std::isinf(missed.missed_exposure->asked_s));
  EXPECT_LT(green_mean(missed.capture).first, 0.5);
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
