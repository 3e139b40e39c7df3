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

TEST(CameraFile, WarnsWhereTheScenesLensHidesTheCameras) {
  const TemporaryFolder folder;
  folder.write("sub/camera.json", R"({"version": 1, "lens": {"f_number": 3}, "sensor": {"bits": 12}})");
  const auto warnings = [&](const json& more) { return read_simulation(scene_with(more), folder / "s.json").warnings; };
  EXPECT_TRUE(warnings(json::object()).empty());
  EXPECT_TRUE(warnings({{"lens", {{"f_number", 4}}}}).empty());
  EXPECT_TRUE(warnings({{"lens", nullptr}}).empty());
  const std::vector<std::string> hidden = warnings({{"lens", {{"model", "thin"}}}});
  ASSERT_EQ(hidden.size(), 1u);
  EXPECT_EQ(hidden[0], (folder / "s.json") + ": /lens: hides the lens of " + (folder / "sub/camera.json") +
                           ", whose sensor alone is used; take both by lens=null");
  folder.write("sub/camera.json", R"({"version": 1, "sensor": {"bits": 12}})");
  EXPECT_TRUE(warnings({{"lens", {{"model", "thin"}}}}).empty());
}

TEST(CameraFile, MapsAreRelativeToTheCamerasFile) {
  const TemporaryFolder folder;
  folder.write("sub/camera.json", R"({"version": 1, "lens": {"model": "aberrated", "left_gain": {"map": "m.exr"}}})");
  Image map(4, 3);
  std::fill(map.data.begin(), map.data.end(), 1.0f);
  write_exr(folder / "sub/m.exr", {{"Y", &map}}, false);
  EXPECT_NO_THROW(read_simulation(scene_with(json::object()), folder / "s.json"));
}

// What a scene says of the lens that it names is the scene's fault, not the lens file's.
TEST(CameraFile, FaultsOfTheScenesOwnLensAreTheScenes) {
  const TemporaryFolder folder;
  folder.write("lens.json", R"({"version": 1, "focal_length_mm": 6, "split": {"model": "ramp", "k": 1.5}})");
  const std::string scene = folder / "s.json", file = folder / "lens.json";
  const auto refusal = [&](const json& more) -> std::string {
    json document = {{"version", 1}, {"gltf", "none.glb"}, {"lens", {{"file", "lens.json"}}}};
    document.merge_patch(more);
    try {
      read_simulation(document, scene);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({{"lens", {{"split", "microlens"}}}}), scene + ": /lens/split: \"microlens\": must be an object");
  EXPECT_EQ(refusal({{"lens", {{"split", {{"model", "table"}}}}}}), scene + ": /lens/split/p: is required");
  EXPECT_EQ(refusal({{"lens", {{"split", {{"k", -1}}}}}}),
            scene + ": /lens/split/k: -1: must be a number in [1, 1e+06]");
  EXPECT_EQ(refusal({{"lens", {{"band_samples", 3}}}}),
            scene + ": /lens/band_samples: is a field of the model 'prescription'; the lens's model is 'thin'");
  EXPECT_EQ(refusal({{"lens", {{"split", {{"model", "table"}, {"p", {-1, 2, 1}}, {"left", {1}}, {"right", {1}}}}}}}),
            scene + ": /lens/split/p: [-1,2,1]: must ascend from -1 or less to 1 or more");
  folder.write("lens.json", R"({"version": 1, "focal_length_mm": 6, "split": {"model": "ramp", "k": 0}})");
  EXPECT_EQ(refusal(json::object()), file + ": /split/k: 0: must be a number in [1, 1e+06]");
}

// A lens that cannot be read is told of before a scale that a lens file takes no notice of.
TEST(CameraFile, FaultsOfThePhotographsLensAreToldOfFirst) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& lens) -> std::string {
    const json truth = {{"photograph_aperture_scale", 5}, {"photograph_lens", lens}};
    try {
      read_simulation({{"version", 1}, {"gltf", "none.glb"}, {"truth", truth}}, folder / "s.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal("none.json").find(folder / "s.json: /truth/photograph_lens: none.json: "), 0u);
  EXPECT_NE(refusal("Own").find("; did you mean 'own'?"), std::string::npos) << refusal("Own");
  folder.write("thin.json", R"({"version": 1, "model": "thin"})");
  EXPECT_NE(refusal("thin.json").find("/truth/photograph_aperture_scale: is that of"), std::string::npos);
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
