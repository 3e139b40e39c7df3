// The whole path through the program, as README.md shows it.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/segmentation/network.h"
#include "tests/run_program.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

using nlohmann::json;

const std::string kScene = "'" DUALPIXEL_SCENES_DIR "/portrait.json'";
/// The default scene's field of view on a sixteenth of its photosites.
const std::string kSmall =
    " --set sensor.width_px=672 --set sensor.height_px=504 --set sensor.pixel_pitch_um=5.6 --set burst.frames=2"
    " --set render.photograph_samples_per_pixel=16";

void must_run(const std::string& arguments) {
  const Outcome outcome = run_program(arguments);
  ASSERT_EQ(outcome.status, 0) << arguments << '\n' << outcome.err;
}

/// The bytes of all files in a folder, by name, but for what records the time a stage took.
std::map<std::string, std::string> contents(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder)] = read_bytes(entry.path());
  }
  return files;
}

TEST(SlowEndToEnd, SmallPortraitThroughAllSubcommands) {
  const TemporaryFolder folder;
  must_run("simulate " + kScene + " -o '" + (folder / "capture") + "'" + kSmall);
  const Outcome info = run_program("info '" + (folder / "capture") + "' --json");
  EXPECT_EQ(json::parse(info.out).is_object(), true);
  for (const std::string mode : {"dp", "dp+seg", "seg"}) {
    const bool finds = mode == "dp+seg" && pipeline::has_person_network();
    const std::string mask = mode == "dp" || finds ? "" : " --true-mask";
    must_run("portrait '" + (folder / "capture") + "' -o '" + (folder / mode) + "' --mode " + mode + mask);
    if (finds) {
      const json result = json::parse(read_bytes(folder / mode + "/result.json"));
      EXPECT_EQ(result["provenance"]["mask"], "found");
    }
    const Outcome score = run_program("score '" + (folder / "capture") + "' '" + (folder / mode) + "' --json");
    ASSERT_EQ(score.status, 0) << score.err;
    const json figures = json::parse(score.out);
    EXPECT_GT(figures["image"]["psnr_db"], 10);
    EXPECT_EQ(figures.contains("disparity"), mode != "seg");
  }
  must_run("report '" + (folder / "dp") + "' '" + (folder / "dp+seg") + "' -o '" + (folder / "report.html") + "'");
  const std::string page = read_bytes(folder / "report.html");
  EXPECT_GT(page.size(), 10000u);
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
}

TEST(SlowEndToEnd, SameBytesForAnyNumberOfThreadsAndInEveryRun) {
  const TemporaryFolder folder;
  for (const std::string threads : {"1", "2", "8", "1 --seed 1"}) {
    const std::string name = "capture" + threads.substr(0, 1) + (threads.size() > 1 ? "again" : "");
    must_run("simulate " + kScene + " -o '" + (folder / name) + "' --threads " + threads + kSmall);
    must_run("portrait '" + (folder / name) + "' -o '" + (folder / name + "_dp") + "' --threads " +
             threads.substr(0, 1));
  }
  const auto first = contents(folder / "capture1");
  EXPECT_GT(first.size(), 5u);
  EXPECT_TRUE(first == contents(folder / "capture2"));
  EXPECT_TRUE(first == contents(folder / "capture8"));
  EXPECT_TRUE(first == contents(folder / "capture1again"));
  for (const std::string picture : {"portrait.exr", "portrait.png", "maps.exr", "input.exr"}) {
    const std::string bytes = read_bytes(folder / "capture1_dp" + "/" + picture);
    EXPECT_FALSE(bytes.empty()) << picture;
    EXPECT_TRUE(bytes == read_bytes(folder / "capture2_dp" + "/" + picture)) << picture;
    EXPECT_TRUE(bytes == read_bytes(folder / "capture8_dp" + "/" + picture)) << picture;
  }
}

// The floors that the first version promised, on the default scene at full size.
TEST(SlowEndToEnd, DefaultSceneMeetsItsFloors) {
  const TemporaryFolder folder;
  must_run("simulate " + kScene + " -o '" + (folder / "capture") + "'");
  must_run("portrait '" + (folder / "capture") + "' -o '" + (folder / "dp") + "' --mode dp");
  const Outcome score = run_program("score '" + (folder / "capture") + "' '" + (folder / "dp") + "' --json");
  ASSERT_EQ(score.status, 0) << score.err;
  const json figures = json::parse(score.out);
  EXPECT_LT(figures["disparity"]["confident"]["rmse_affine_px"], 0.15) << score.out;
  EXPECT_GT(figures["image"]["psnr_db"].get<double>() - figures["image"]["psnr_input_db"].get<double>(), 4)
      << score.out;
}

}  // namespace
}  // namespace dualpixel
