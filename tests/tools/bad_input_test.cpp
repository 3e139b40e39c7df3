// What a user can get wrong, given to the program as a user would: status 2, one line that names the fault, no output.
#include <gtest/gtest.h>
#include <unistd.h>

#include "capture/json_fields.h"
#include "pipeline/segmentation/network.h"
#include "tests/simulator/scene/gltf/gltf_builder.h"
#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

using nlohmann::json;
using simulator::GltfBuilder;

/// A triangle in front of a camera, with a scene file beside it.
class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    gltf.add_accessor<float>({-1, -1, -1, 1, -1, -1, 0, 1, -1}, "VEC3");
    gltf.add_accessor<std::uint16_t>({0, 1, 2}, "SCALAR");
    gltf.root["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}};
    gltf.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.6}, {"znear", 0.1}}}}};
    gltf.root["nodes"] = {{{"mesh", 0}}, {{"camera", 0}, {"name", "camera"}}};
    gltf.root["scenes"] = {{{"nodes", {0, 1}}}};
    scene = {{"version", 1},
             {"gltf", "scene.glb"},
             {"sensor", {{"width_px", 32}, {"height_px", 32}}},
             {"environment", {{"model", "constant"}, {"nits", {100, 100, 100}}}}};
  }

  Outcome simulate(const std::string& options = "", const std::string& output = "out") {
    if (glb.empty()) glb = gltf.glb();
    write_bytes(folder / "scene.glb", glb);
    write_bytes(folder / "scene.json", scene.dump());
    return run_command("simulate '" + (folder / "scene.json") + "' -o '" + (folder / output) + "' " + options);
  }

  void expect_refusal(const std::vector<std::string>& words, const std::string& options = "",
                      const std::string& output = "out") {
    const Outcome outcome = simulate(options, output);
    expect_one_line_refusal(outcome);
    for (const std::string& word : words) EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    EXPECT_EQ(folder.names(), (std::set<std::string>{"scene.glb", "scene.json"}));
  }

  TemporaryFolder folder;
  GltfBuilder gltf;
  json scene;
  std::string glb;  ///< in place of gltf's own bytes, where not empty
};

TEST_F(BadInput, TheSceneItselfIsFine) {
  const Outcome outcome = simulate();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "out" + "/capture.json"));
}

// As a shell's variable that is not set leaves it.
TEST(BadCommand, AnEmptyValueIsNotLikeNone) {
  for (const std::string command :
       {"portrait capture -o out --calibration", "portrait -o out --left", "info", "evaluate set -o out --method",
        "score capture --disparity", "plan scene.json -o"}) {
    const Outcome outcome = run_command(command + " ''");
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("must not be empty"), std::string::npos) << command << ": " << outcome.err;
  }
}

TEST_F(BadInput, TruncatedGlb) {
  glb = gltf.glb();
  glb.resize(glb.size() - 20);
  expect_refusal({"scene.glb"});
}

TEST_F(BadInput, AccessorOutOfRange) {
  gltf.root["accessors"][0]["count"] = 1000000;
  expect_refusal({"scene.glb", "/accessors/0", "1000000"});
}

TEST_F(BadInput, IndexBeyondTheVertexCount) {
  GltfBuilder broken = gltf;
  broken.root["accessors"][1]["bufferView"] = broken.add_view(std::vector<std::uint16_t>{0, 1, 7}.data(), 6);
  gltf = broken;
  expect_refusal({"scene.glb", "7"});
}

TEST_F(BadInput, NanVertex) {
  const std::vector<float> positions = {-1, -1, -1, NAN, -1, -1, 0, 1, -1};
  gltf.root["accessors"][0]["bufferView"] = gltf.add_view(positions.data(), 36);
  expect_refusal({"scene.glb", "nan"});
}

TEST_F(BadInput, CyclicNodes) {
  gltf.node(0)["children"] = {1};
  gltf.node(1)["children"] = {0};
  expect_refusal({"scene.glb", "/nodes"});
}

TEST_F(BadInput, MissingBuffer) {
  gltf.root["buffers"] = {{{"byteLength", 100}, {"uri", "nowhere.bin"}}};
  expect_refusal({"nowhere.bin"});
}

TEST_F(BadInput, MissingTexture) {
  gltf.root["images"] = {{{"uri", "nowhere.png"}}};
  gltf.root["textures"] = {{{"source", 0}}};
  gltf.root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  gltf.primitive()["material"] = 0;
  expect_refusal({"nowhere.png"});
}

TEST_F(BadInput, PathThatClimbsOut) {
  gltf.root["buffers"] = {{{"byteLength", 100}, {"uri", "../../../../etc/passwd"}}};
  expect_refusal({"etc/passwd"});
}

TEST_F(BadInput, MissingGltf) {
  scene["gltf"] = "another.glb";
  expect_refusal({"another.glb"});
}

TEST_F(BadInput, NoLight) {
  scene.erase("environment");
  expect_refusal({"no light"});
}

TEST_F(BadInput, NoCamera) {
  gltf.root["nodes"] = {{{"mesh", 0}}};
  gltf.root["scenes"] = {{{"nodes", {0}}}};
  gltf.root.erase("cameras");
  expect_refusal({"camera"});
}

TEST_F(BadInput, FocusInsideTheFocalLength) {
  expect_refusal({"focus_distance_m", "0.004", "focal length"}, "--set camera.focus_distance_m=0.004");
}

TEST_F(BadInput, ZeroAperture) { expect_refusal({"/lens/f_number", "0"}, "--set lens.f_number=0"); }

TEST_F(BadInput, CamerasBeyondWhatRaysReach) {
  for (const std::string far : {"9223372036854775808", "-18446744073709551616", "1e308"}) {
    const std::string at = "--set 'camera.look_at_m=[0,0,-1]' --set 'camera.position_m=[0,0,";
    expect_refusal({"scene.json: /camera/position_m", "[-1000000, 1000000]"}, at + far + "]'");
    expect_refusal({"scene.json: /camera/up", "[-1000000, 1000000]"}, at + "0]' --set 'camera.up=[0," + far + ",0]'");
  }
}

TEST_F(BadInput, WhatTheCaptureCannotHoldIsRefusedAsTheScenesField) {
  expect_refusal({"scene.json: /truth/photograph_aperture_scale: 0"}, "--set truth.photograph_aperture_scale=0");
  expect_refusal({"scene.json: /sensor/electrons_per_lux_s: 1e-300"},
                 "--set 'sensor.electrons_per_lux_s=[1e-300,1e-300,1e-300]'");
  expect_refusal({"scene.json: /sensor/illuminant: 1e-300"}, "--set 'sensor.illuminant=[1e-300,1,1]'");
}

TEST_F(BadInput, AFieldOfAnotherSplitThanTheLensFilesIsTheScenes) {
  const std::string file =
      "--set 'lens={\"file\": \"" DUALPIXEL_SOURCE_DIR "/lens_models/phone_6p_4.2mm_f1.8.json\"}' ";
  expect_refusal({"scene.json: /lens/split/k: is a field of the model 'ramp'"}, file + "--set lens.split.k=4");
  expect_refusal({"scene.json: /lens/split/kk: unknown field"}, file + "--set lens.split.kk=4");
}

TEST_F(BadInput, NegativeExposure) { expect_refusal({"/exposure/time_s", "-1"}, "--set exposure.time_s=-1"); }

TEST_F(BadInput, UnknownFieldNamesTheNearest) {
  expect_refusal({"focus_distnce_m", "'focus_distance_m'"}, "--set camera.focus_distnce_m=1");
}

TEST_F(BadInput, ImageBeyondMemory) {
  expect_refusal({"/sensor", "GB"}, "--set sensor.width_px=8192 --set sensor.height_px=6400 --set burst.frames=1000");
}

TEST_F(BadInput, AnimationThatLetsTrianglesVanish) {
  const int times = gltf.add_accessor<float>({0, 1}, "SCALAR");
  const int scales = gltf.add_accessor<float>({1, 1, 1, 0, 0, 0}, "VEC3");
  const json sampler = {{"input", times}, {"output", scales}, {"interpolation", "STEP"}};
  const json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}};
  gltf.root["animations"] = json::array({{{"samplers", {sampler}}, {"channels", {channel}}}});
  expect_refusal({"triangle"}, "--set burst.animation=true --set burst.frames=2 --set burst.interval_s=2");
}

TEST_F(BadInput, AnAnimationThatNamesSamplersAndHasNone) {
  const json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}};
  gltf.root["animations"] = json::array({{{"samplers", json::array()}, {"channels", {channel}}}});
  expect_refusal({"scene.glb", "/animations/0/channels/0/sampler: 0: the animation has no samplers"},
                 "--set burst.animation=true --set burst.frames=2 --set burst.interval_s=2");
}

TEST_F(BadInput, FramesCloserThanTheirExposure) {
  expect_refusal({"/burst/interval_s", "0.001"}, "--set burst.interval_s=0.001");
}

TEST_F(BadInput, OutputIntoAFileForAFolder) { expect_refusal({"scene.json/out"}, "", "scene.json/out"); }

TEST_F(BadInput, OutputThatIsAFile) {
  const Outcome outcome = simulate("", "scene.json");
  expect_one_line_refusal(outcome);
  EXPECT_NE(outcome.err.find("scene.json"), std::string::npos);
  EXPECT_EQ(read_bytes(folder / "scene.json"), scene.dump());
}

TEST_F(BadInput, OutputFolderThatIsNotOurs) {
  std::filesystem::create_directory(folder / "precious");
  write_bytes(folder / "precious" + "/thesis.txt", "words");
  const Outcome outcome = simulate("", "precious");
  expect_one_line_refusal(outcome);
  EXPECT_EQ(read_bytes(folder / "precious" + "/thesis.txt"), "words");
}

TEST_F(BadInput, AStudyInPlaceOfAnotherWithItsVotes) {
  std::filesystem::create_directory(folder / "study");
  for (const char* name : {"/study.json", "/votes_A.json"}) write_bytes(folder / "study" + name, "{}");
  const Outcome outcome =
      run_command("experiment votes --portraits a=x --portraits b=y -o '" + (folder / "study") + "'");
  expect_one_line_refusal(outcome);
  EXPECT_NE(outcome.err.find("holds a study"), std::string::npos) << outcome.err;
  EXPECT_EQ(read_bytes(folder / "study" + "/votes_A.json"), "{}");
}

TEST_F(BadInput, PathsThatTheSystemRefuses) {
  const std::string path = std::string(5000, 'a');  // beyond PATH_MAX
  std::vector<std::string> commands = {"info ",
                                       "score x ",
                                       "report -o out.html ",
                                       "portrait -o out ",
                                       "evaluate --method likelihood -o out ",
                                       "experiment votes --portraits a=x --portraits b=y -o "};
  if (pipeline::has_person_network()) commands.emplace_back("experiment methods -o ");
  for (const std::string& command : commands) {
    const Outcome outcome = run_command(command + path);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("aaaa"), std::string::npos) << command << outcome.err.substr(0, 200);
  }
}

TEST_F(BadInput, OutputIntoAReadOnlyFolder) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write into read-only folders";
  std::filesystem::create_directory(folder / "locked");
  std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_read);
  expect_one_line_refusal(simulate("", "locked/out"));
}

}  // namespace
}  // namespace dualpixel
