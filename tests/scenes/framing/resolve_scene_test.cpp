#include "scenes/framing/resolve_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "scenes/framing/scene_document.h"
#include "scenes/gltf/glb.h"
#include "simulator/simulate.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;

/// A glTF file of two walls that face +z, each 0.2 m wide: "near" on the left at z = 0.5, "far" on the right at z = 0;
/// with a camera at z = 2.5 unless told otherwise.
std::string two_walls(const TemporaryFolder& folder, bool with_camera = true) {
  Glb glb;
  const int material = glb.add_material({.color = {0.5, 0.5, 0.5}});
  Mesh near, far;
  near.add_quad({-0.2, -0.15, 0.5}, {0.2, 0, 0}, {0, 0.3, 0});
  far.add_quad({0, -0.15, 0}, {0.2, 0, 0}, {0, 0.3, 0});
  glb.add_node("near", near, material);
  glb.add_node("far", far, material);
  if (with_camera) glb.add_camera("camera", {0, 0, 2.5}, {0, 0, 0});
  glb.write(folder / "walls.glb");
  return folder / "walls.glb";
}

/// A scene file of it whose picture is 0.3 x 0.225 of its distance.
json document(const json& camera) {
  return {{"version", 1},
          {"gltf", "walls.glb"},
          {"camera", camera},
          {"lens", {{"focal_length_mm", 4.4}}},
          {"sensor", {{"width_px", 128}, {"height_px", 96}, {"pixel_pitch_um", 10.3}}},
          {"environment", {{"model", "sky"}}}};
}

double focus_of(const json& camera, const TemporaryFolder& folder) {
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<std::string> warnings;
  const json resolved = resolve_scene(document(camera), folder / "scene.json", ready, warnings);
  simulator::read_simulation(resolved, folder / "scene.json");  // nothing is left that it does not know
  return resolved.at("camera").at("focus_distance_m").get<double>();
}

std::string refusal(const json& camera, const TemporaryFolder& folder) {
  return message_of<InputError>([&] { focus_of(camera, folder); });
}

// Four digits are kept, and rays are single precision.
TEST(ResolveScene, FocusesOnSurfaces) {
  const TemporaryFolder folder;
  two_walls(folder);
  EXPECT_NEAR(focus_of({{"focus_at_px", {40, 48}}}, folder), 2, 1e-3);
  EXPECT_NEAR(focus_of({{"focus_at_px", {80, 48}}}, folder), 2.5, 1e-3);
  // Below the far wall, 2 photosites from it and 6 from the near one, which alone is seen in this row.
  EXPECT_NEAR(focus_of({{"focus_at_px", {70, 76}}}, folder), 2.5, 1e-3);
  EXPECT_NEAR(focus_of({{"focus_node", "near"}}, folder), 2, 1e-3);
  EXPECT_NEAR(focus_of({{"focus_node", "far"}}, folder), 2.5, 1e-3);
  // aside, so that one wall fills the middle
  const json aside = {{"position_m", {0.1, 0, 2.5}}, {"look_at_m", {0.1, 0, 0}}, {"focus_distance_m", "auto"}};
  EXPECT_NEAR(focus_of(aside, folder), 2.5, 1e-3);
}

TEST(ResolveScene, RefusesWhatCannotBeFocusedOn) {
  const TemporaryFolder folder;
  two_walls(folder);
  const std::string path = folder / "scene.json";
  EXPECT_EQ(refusal({{"focus_node", "nearr"}}, folder),
            path + ": /camera/focus_node: nearr: the glTF file has no such node; did you mean 'near'?");
  EXPECT_EQ(refusal({{"focus_at_px", {200, 48}}}, folder),
            path + ": /camera/focus_at_px: [200, 48]: must lie in the picture of 128 x 96 photosites");
  EXPECT_EQ(
      refusal({{"focus_at_px", {40, 48}}, {"focus_node", "near"}}, folder),
      path + ": /camera/focus_node: give one of focus_distance_m, focus_at_px and focus_node; null takes a field away");
  const json away = {{"position_m", {0, 0, 2.5}}, {"look_at_m", {0, 0, 5}}};
  for (const auto& [field, value] :
       {std::pair<const char*, json>{"focus_distance_m", "auto"}, {"focus_at_px", {9, 9}}}) {
    json camera = away;
    camera[field] = value;
    EXPECT_NE(refusal(camera, folder).find("the camera sees no surface"), std::string::npos);
  }
  json camera = away;
  camera["focus_node"] = "near";
  EXPECT_NE(refusal(camera, folder).find("the camera sees nothing of it"), std::string::npos);
}

TEST(ResolveScene, LeavesOtherDocumentsAlone) {
  const TemporaryFolder folder;  // no glTF file: nothing is loaded
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<std::string> warnings;
  const json plain = document({{"focus_distance_m", 0.7}});
  EXPECT_EQ(resolve_scene(plain, folder / "scene.json", ready, warnings), plain);
  EXPECT_EQ(ready, nullptr);
}

TEST(ResolveScene, ScalesTheModelByAFactor) {
  const TemporaryFolder folder;
  two_walls(folder);
  json scene = document({{"focus_node", "near"}});
  scene["model_scale"] = 0.1;
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<std::string> warnings;
  const json resolved = resolve_scene(scene, folder / "scene.json", ready, warnings);
  EXPECT_NEAR(resolved.at("model_size_m").get<double>(), 0.05, 1e-6);  // 0.4 x 0.3 x 0.5 m before
  EXPECT_NEAR(resolved.at("camera").at("focus_distance_m").get<double>(), 0.2, 1e-4);
  EXPECT_FALSE(resolved.contains("model_scale"));
  scene["model_scale"] = 1.0003;
  EXPECT_NEAR(resolve_scene(scene, folder / "scene.json", ready, warnings)["model_size_m"].get<double>(), 0.50015,
              1e-7);
  scene["model_size_m"] = 1;
  EXPECT_EQ(message_of<InputError>([&] { resolve_scene(scene, "s.json", ready, warnings); }),
            "s.json: /model_scale: give either model_scale or model_size_m");
}

// All of the model is in the picture, and the camera is where its ball fills the picture's shorter side but 5 %.
TEST(ResolveScene, FramesABareModel) {
  const TemporaryFolder folder;
  const std::string path = two_walls(folder, false);
  json scene = read_scene_document(path);
  apply_override(scene, "sensor.width_px=128");
  apply_override(scene, "sensor.height_px=96");
  apply_override(scene, "sensor.pixel_pitch_um=29.4");
  apply_override(scene, "burst.frames=1");
  apply_override(scene, "render.samples_per_pixel=16");
  apply_override(scene, "render.photograph_samples_per_pixel=1");
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<std::string> warnings;
  const json resolved = resolve_scene(scene, path, ready, warnings);
  const simulator::Simulation s = simulator::read_simulation(resolved, path);
  ASSERT_TRUE(s.pose);
  const double radius = 0.5 * std::hypot(0.4, 0.3, 0.5),
               half_angle = std::atan(48 * 29.4e-6 / s.lens.thin.focal_length_m);
  EXPECT_NEAR(glm::length(s.pose->position_m - s.pose->look_at_m), 1.05 * radius / std::sin(half_angle), 1e-3);
  EXPECT_EQ(s.environment_model, simulator::EnvironmentModel::sky);

  simulator::make_ready(s, ready);
  const Capture capture = simulator::simulate(s, ready->scene);
  const Truth& truth = *capture.truth;
  double seen = 0, mean = 0;
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      const bool border = x == 0 || y == 0 || x == 127 || y == 95;
      EXPECT_FALSE(border && truth.valid.at(x, y) == 1) << x << " " << y;
      seen += truth.valid.at(x, y);
    }
  }
  EXPECT_GT(seen, 0.05 * 128 * 96);
  // the mean of the green signal, clipped at white, is 0.18: metered on 48 x 36 photosites of 4 samples, and exposure
  // is kept to two digits
  const Image signal = normalized(capture.frames[0].mosaic, capture.exposure);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) mean += (x + y) % 2 ? std::min(1.0f, signal.at(x, y)) : 0;
  }
  EXPECT_NEAR(mean / (64 * 96), 0.18, 0.02);
}

TEST(ResolveScene, WarnsWhereNoExposureGivesTheMean) {
  const TemporaryFolder folder;
  const std::string path = two_walls(folder);
  json scene = read_scene_document(path);
  scene["environment"] = {{"model", "constant"}, {"nits", {1e-4, 1e-4, 1e-4}}};
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<std::string> warnings;
  const json resolved = resolve_scene(scene, path, ready, warnings);
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_TRUE(warnings[0].starts_with(path + ": exposure: ")) << warnings[0];
  EXPECT_TRUE(warnings[0].ends_with(" s at ISO 100 are asked for; the limit is 10.7 s, taken are 10.6 s"))
      << warnings[0];  // 1/12 s has two digits
  EXPECT_EQ(resolved["exposure"], (json{{"time_s", 0.083}, {"iso", 12800}}));
}

TEST(ResolveScene, KeepsTheCameraOfAModelThatHasOne) {
  const TemporaryFolder folder;
  const std::string path = two_walls(folder);
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<std::string> warnings;
  json scene = read_scene_document(path);
  scene["exposure"] = {{"time_s", 0.01}};
  const json resolved = resolve_scene(scene, path, ready, warnings);
  EXPECT_FALSE(resolved.at("camera").contains("position_m"));
  EXPECT_EQ(resolved.at("exposure"), scene.at("exposure"));
}

}  // namespace
}  // namespace dualpixel::scenes
