// The camera file that a scene names: its lens and sensor hold where the scene has none of its own.
#include <gtest/gtest.h>

#include <algorithm>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "simulator/scene_file.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

using nlohmann::json;

json scene_with(const json& more) {
  json scene = {{"version", 1}, {"gltf", "none.glb"}, {"camera", {{"file", "sub/camera.json"}}}};
  scene.merge_patch(more);
  return scene;
}

TEST(CameraFile, HoldsWhereTheSceneSaysNothing) {
  const TemporaryFolder folder;
  folder.write("sub/lens.json", R"({"version": 1, "model": "thin", "focal_length_mm": 6, "f_number": 2})");
  folder.write(
      "sub/camera.json",
      R"({"version": 1, "lens": {"file": "lens.json", "f_number": 3}, "sensor": {"width_px": 64, "bits": 12}})");
  const auto read = [&](const json& more) { return read_simulation(scene_with(more), folder / "s.json"); };
  const Simulation plain = read(json::object());
  EXPECT_DOUBLE_EQ(plain.lens.thin.focal_length_m, 6e-3);
  EXPECT_DOUBLE_EQ(plain.lens.thin.f_number, 3);
  EXPECT_EQ(plain.sensor.width_px, 64);
  EXPECT_EQ(plain.sensor.bits, 12);
  const Simulation over = read({{"lens", {{"f_number", 4}}}, {"sensor", {{"bits", 10}}}});
  EXPECT_DOUBLE_EQ(over.lens.thin.focal_length_m, 6e-3);
  EXPECT_DOUBLE_EQ(over.lens.thin.f_number, 4);
  EXPECT_EQ(over.sensor.width_px, 64);
  EXPECT_EQ(over.sensor.bits, 10);
  EXPECT_DOUBLE_EQ(read({{"lens", {{"model", "thin"}}}}).lens.thin.focal_length_m, 4.442e-3);
}

TEST(CameraFile, FieldsOfTheSceneAreLaidOverAtAnyDepth) {
  const TemporaryFolder folder;
  folder.write("sub/camera.json",
               R"({"version": 1, "lens": {"split": {"model": "ramp", "k": 1.5}}, "sensor": {"bits": 12}})");
  const auto read = [&](const json& more) { return read_simulation(scene_with(more), folder / "s.json"); };
  const Simulation leaking = read({{"lens", {{"split", {{"crosstalk", 0.05}}}}}});
  EXPECT_EQ(leaking.lens.split.kind, SplitKind::ramp);
  EXPECT_DOUBLE_EQ(leaking.lens.split.k, 1.5);
  EXPECT_DOUBLE_EQ(leaking.lens.split.crosstalk, 0.05);
  EXPECT_EQ(read({{"lens", {{"split", {{"model", "hard"}}}}}}).lens.split.kind, SplitKind::hard);
  // what is written into the capture renders the same without the camera's file
  folder.write("sub/camera.json", "{}");
  const Simulation again = read_simulation(leaking.json, folder / "s.json");
  EXPECT_DOUBLE_EQ(again.lens.split.k, 1.5);
  EXPECT_EQ(again.sensor.bits, 12);
}

TEST(CameraFile, TheLensOfAFileThatTheSceneReplacesMayBeAnything) {
  const TemporaryFolder folder;
  folder.write("sub/camera.json", R"({"version": 1, "lens": {"focal_length_mm": 50}})");
  const json close = {{"camera", {{"focus_distance_m", 0.04}}}, {"lens", {{"model", "thin"}}}};
  EXPECT_DOUBLE_EQ(read_simulation(scene_with(close), folder / "s.json").lens.thin.focal_length_m, 4.442e-3);
}

TEST(CameraFile, MapsAreRelativeToTheCamerasFile) {
  const TemporaryFolder folder;
  folder.write("sub/camera.json", R"({"version": 1, "lens": {"model": "aberrated", "left_gain": {"map": "m.exr"}}})");
  Image map(4, 3);
  std::fill(map.data.begin(), map.data.end(), 1.0f);
  write_exr(folder / "sub/m.exr", {{"Y", &map}}, false);
  EXPECT_NO_THROW(read_simulation(scene_with(json::object()), folder / "s.json"));
}

TEST(CameraFile, FaultsAreToldOfTheFileThatHasThem) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& camera) -> std::string {
    folder.write("sub/camera.json", camera);
    try {
      read_simulation(scene_with(json::object()), folder / "s.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(R"({"version": 1})"), "");
  EXPECT_NE(refusal(R"({"version": 1, "lens": {"f_number": -1}})").find("sub/camera.json: /lens/f_number: -1"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"version": 1, "sensor": {"bits": 3}})").find("sub/camera.json: /sensor/bits: 3"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"version": 1, "sensr": {}})").find("sub/camera.json: /sensr: unknown field"),
            std::string::npos);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
