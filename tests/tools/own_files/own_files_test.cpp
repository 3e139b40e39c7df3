// Scenes, methods and maps that people bring, as they give them on the command line.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <utility>

#include "capture/capture.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "scenes/gltf/glb.h"
#include "tests/datasets/small_recipe.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/pipeline/texture.h"
#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

using nlohmann::json;

/// Whether there is no such process, or only until it is reaped; killed ones are given two seconds.
bool has_ended(int pid) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    std::ifstream stat(fmt::format("/proc/{}/stat", pid));
    std::string number, name;
    char state = 'X';
    stat >> number >> name >> state;
    if (state == 'X' || state == 'Z') return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

/// A glTF file without a camera: a quad before another.
void write_model(const std::string& path) {
  scenes::Glb glb;
  const int material = glb.add_material({.color = {0.5, 0.5, 0.5}});
  scenes::Mesh near, far;
  near.add_quad({-0.2, -0.15, 0.1}, {0.2, 0, 0}, {0, 0.3, 0});
  far.add_quad({0, -0.15, 0}, {0.2, 0, 0}, {0, 0.3, 0});
  glb.add_node("near", near, material);
  glb.add_node("far", far, material);
  glb.write(path);
}

constexpr const char* kTinyPictures =
    " --set sensor.width_px=64 --set sensor.height_px=48 --set sensor.pixel_pitch_um=58.8 --set burst.frames=1 --set "
    "render.samples_per_pixel=2 --set render.photograph_samples_per_pixel=1 --set render.light_spacing_px=0";

TEST(SlowOwnScenes, AModelAloneIsFramedAndItsSceneFilePrinted) {
  const TemporaryFolder folder;
  write_model(folder / "model.glb");
  const std::string in = "'" + folder.path.string() + "/";
  const Outcome outcome = run_command("simulate " + in + "model.glb' -o " + in + "one' --seed 3" + kTinyPictures);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json printed = json::parse(outcome.out);
  EXPECT_TRUE(printed["camera"]["focus_distance_m"].is_number());
  EXPECT_EQ(json::parse(read_bytes(folder / "one/capture.json"))["provenance"]["scene"], printed);

  // saved beside the model it is the scene: the same frames
  folder.write("model.json", outcome.out);
  const Outcome again = run_command("simulate " + in + "model.json' -o " + in + "two'");
  ASSERT_EQ(again.status, 0) << again.err;
  for (const char* file : {"frames/000_mosaic.png", "frames/000_left.png", "truth/geometry.exr"}) {
    EXPECT_EQ(read_bytes(folder / "one/" + file), read_bytes(folder / "two/" + file)) << file;
  }
  const Outcome dry = run_command("simulate " + in + "model.glb' -o " + in + "dry' --dry-run --seed 3" + kTinyPictures);
  EXPECT_EQ(dry.out, outcome.out);
  EXPECT_FALSE(std::filesystem::exists(folder / "dry"));
  std::filesystem::create_directory(folder / "mine");
  write_bytes(folder / "mine/notes", "1");
  const Outcome mine = run_command("simulate " + in + "model.glb' -o " + in + "mine' --dry-run" + kTinyPictures);
  EXPECT_EQ(mine.status, 2);
  EXPECT_NE(mine.err.find("will not be overwritten"), std::string::npos) << mine.err;
}

TEST(SlowOwnScenes, InfoSaysWhatAModelHolds) {
  const TemporaryFolder folder;
  write_model(folder / "model.glb");
  const json info = json::parse(run_command("info '" + (folder / "model.glb") + "' --json").out);
  const double expected[] = {-0.2, -0.15, 0, 0.2, 0.15, 0.1};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(info["bounds"][i < 3 ? "low_m" : "high_m"][i % 3].get<double>(), expected[i], 1e-6);
  }
  EXPECT_EQ(info["materials"].size(), 1);
  EXPECT_EQ(info["cameras"], json::array());
  EXPECT_TRUE(info.contains("extensions"));
  const json planes = json::parse(run_command("info '" DUALPIXEL_SCENES_DIR "/slanted_planes.glb' --json").out);
  EXPECT_EQ(planes["cameras"][0]["name"], "camera");
  EXPECT_EQ(planes["extensions"], json({"KHR_materials_unlit"}));
}

TEST(SlowOwnScenes, SeveralGoToFoldersOfTheirNames) {
  const TemporaryFolder folder;
  write_model(folder / "model.glb");
  const std::string in = "'" + folder.path.string() + "/";
  const std::string planes = "'" DUALPIXEL_SCENES_DIR "/slanted_planes.json' ";
  const Outcome outcome = run_command("simulate " + planes + in + "model.glb' -o " + in + "out'" + kTinyPictures);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "out/slanted_planes/capture.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/model/capture.json"));
  expect_one_line_refusal(run_command("simulate " + planes + planes + "-o " + in + "twice'" + kTinyPictures));
}

// A camera that the second scene lacks is only known when it is loaded.
TEST(SlowOwnScenes, AllAreCheckedBeforeTheFirstIsRendered) {
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  const std::string planes = "'" DUALPIXEL_SCENES_DIR "/slanted_planes.json' ";
  folder.write("none.json", json{{"version", 1},
                                 {"gltf", DUALPIXEL_SCENES_DIR "/slanted_planes.glb"},
                                 {"camera", {{"node", "none"}, {"focus_distance_m", 1}}},
                                 {"lens", {{"focal_length_mm", 4.4}, {"f_number", 1.8}}}}
                                .dump());
  const Outcome outcome = run_command("simulate " + planes + in + "none.json' -o " + in + "out'" + kTinyPictures);
  expect_one_line_refusal(outcome);
  EXPECT_NE(outcome.err.find("no camera node is named 'none'"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));

  folder.write("jobs.jsonl", "{\"name\": \"a\"}\n{\"name\": \"b\", \"set\": {\"camera.node\": \"none\"}}\n");
  expect_one_line_refusal(
      run_command("simulate " + planes + "--jobs " + in + "jobs.jsonl' -o " + in + "out'" + kTinyPictures));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(SlowOwnScenes, AFaceMayBeGivenInSharesAndRemoved) {
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  const std::string scene = "simulate '" DUALPIXEL_SCENES_DIR "/slanted_planes.json' -o " + in;
  const Outcome shares = run_command(scene + "a'" + kTinyPictures + " --set 'face=[0.25,0.5,0.25,0.25]'");
  ASSERT_EQ(shares.status, 0) << shares.err;
  EXPECT_EQ(json::parse(read_bytes(folder / "a/capture.json"))["face_px"], json({16, 24, 16, 12}));
  const Outcome none = run_command(scene + "b'" + kTinyPictures + " --set 'face=[0.25,0.5,0.25,0.25]' --set face=null");
  ASSERT_EQ(none.status, 0) << none.err;
  EXPECT_FALSE(json::parse(read_bytes(folder / "b/capture.json")).contains("face_px"));
  expect_one_line_refusal(run_command(scene + "c'" + kTinyPictures + " --set 'face=[0.9,0.5,0.25,0.25]'"));
  expect_one_line_refusal(
      run_command(scene + "c'" + kTinyPictures + " --set 'face=[0,0,1,1]' --set 'face_px=[1,1,2,2]'"));
}

TEST(PortraitCommand, TakesADisparityOfAnyProgram) {
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  write_png8(folder / "l.png", pipeline::textured(pipeline::Texture(5, 0.2), 129, 95, 0));
  write_png8(folder / "r.png", pipeline::textured(pipeline::Texture(5, 0.2), 129, 95, 1));
  const std::string portrait = "portrait --mode dp --left " + in + "l.png' --right " + in + "r.png' ";
  ASSERT_EQ(run_command(portrait + "--matcher paper -o " + in + "matched'").status, 0);
  std::vector<Image> found = read_exr(folder / "matched/matched.exr", {"disparity_dp_px", "confidence"});
  write_exr(folder / "d.exr", {{"any_name", found.data()}}, false);
  write_npy(folder / "c.npy", found[1]);
  const std::string given = portrait + "-o " + in + "given' --disparity " + in;
  const Outcome outcome = run_command(given + "d.exr' --confidence " + in + "c.npy'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* file : {"portrait.png", "maps.exr"}) {  // smoothed as the paper's
    EXPECT_EQ(read_bytes(folder.path / "given" / file), read_bytes(folder.path / "matched" / file)) << file;
  }
  const Outcome unused = run_command(given + "d.exr' --set split_match.range_px=12");
  expect_one_line_refusal(unused);
  EXPECT_NE(unused.err.find("split_match.range_px: disparity is given, not matched"), std::string::npos) << unused.err;
  EXPECT_EQ(json::parse(read_bytes(folder / "given/result.json"))["provenance"]["disparity"], folder / "d.exr");

  write_npy(folder / "stored.npy", Image(129, 95));  // as large as the pictures, whose sides are made even
  EXPECT_EQ(run_command(given + "stored.npy'").status, 0);
  write_npy(folder / "small.npy", Image(128, 95));
  const Outcome small = run_command(given + "small.npy'");
  expect_one_line_refusal(small);
  EXPECT_NE(small.err.find("small.npy: 128 x 95 pixels of 1 channel: must be one channel of 130 x 96"),
            std::string::npos)
      << small.err;
  expect_one_line_refusal(run_command(given + "d.exr' --mode seg"));
  expect_one_line_refusal(run_command(given + "d.exr' --matcher split"));
  expect_one_line_refusal(run_command(portrait + "-o " + in + "given' --sigma " + in + "c.npy'"));
}

TEST(SlowEvaluateCommand, ComparesMethodsOverADataSet) {
  const TemporaryFolder folder;
  json recipe = datasets::testing::small_recipe(2);
  recipe["keep"] = {"left", "right", "view_disparity_dp_px", "view_valid"};
  folder.write("recipe.json", recipe.dump());
  const std::string in = "'" + folder.path.string() + "/";
  ASSERT_EQ(run_command("dataset plan " + in + "recipe.json' -o " + in + "set'").status, 0);
  ASSERT_EQ(run_command("dataset render " + in + "set'").status, 0);
  const std::string command = "evaluate " + in + "set' -o " + in + "out' --method paper ";
  const Outcome outcome = run_command(command + "--method 'mine=cp {left.npy} {out}; : {right}'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json evaluation = json::parse(read_bytes(folder / "out/evaluation.json"));
  EXPECT_EQ(evaluation["samples"], 2);
  EXPECT_TRUE(evaluation["methods"]["mine"].contains("peak_rss_mb"));
  EXPECT_EQ(evaluation["methods"]["mine"]["regions"]["everything"]["pixels"],
            evaluation["methods"]["paper"]["regions"]["everything"]["pixels"]);
  EXPECT_TRUE(std::filesystem::exists(folder / "out/evaluation.html"));
  expect_one_line_refusal(run_command(command + "--method paper"));
  expect_one_line_refusal(run_command(command + "--split tst"));
}

// A shell within a shell that waits for its child: all are in the group that is killed.
TEST(SlowEvaluateCommand, EndsItsProgramsWhenASignalOrTimeEndsIt) {
  const TemporaryFolder folder;
  write_capture(pipeline::synthetic_capture(), folder / "set/one");
  std::filesystem::create_directory(folder / "scratch");
  const std::string in = "'" + folder.path.string() + "/";
  folder.write("method.sh", "sleep 600 & echo $$ $! >" + in + "pids'; wait\n");
  struct Case {
    const char *option, *end;
    int status;
  };
  for (const auto& [option, end, status] :
       {Case{"", "kill -TERM $!", 143}, {"", "kill -INT $!", 130}, {"--max-time 10 ", "true", 2}}) {
    SCOPED_TRACE(status);
    std::filesystem::remove(folder / "pids");
    folder.write("run.sh", "TMPDIR=" + in + "scratch' '" DUALPIXEL_PROGRAM "' " + option + "evaluate " + in +
                               "set' -o " + in + "out' --method \"slow=sh " + in +
                               "method.sh'; : {left} {right} {out}\" &\n" + "while kill -0 $! && ! test -s " + in +
                               "pids'; do sleep 0.05; done\n" + end + "\nwait $!\n");
    EXPECT_EQ(run_program("--version >/dev/null; sh " + in + "run.sh'").status, status);
    std::istringstream pids(read_bytes(folder / "pids"));
    int shell = 0, child = 0;
    pids >> shell >> child;
    ASSERT_GT(child, 1);
    for (const int pid : {shell, child}) EXPECT_TRUE(has_ended(pid)) << pid;
    EXPECT_TRUE(std::filesystem::is_empty(folder / "scratch"));
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  }
}

}  // namespace
}  // namespace dualpixel
