#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

using pipeline::synthetic_capture;
using pipeline::synthetic_result;

TEST(ScoreCommand, WritesItsFiguresBesideTheResult) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  write_capture(capture, folder / "c");
  pipeline::write_result(pipeline::synthetic_result(capture), {{"mode", "dp"}}, folder / "r");
  CLI::App program;
  add_score(program);
  ::testing::internal::CaptureStdout();
  program.parse(std::vector<std::string>{"--json", folder / "r", folder / "c", "score"});  // CLI11 takes them reversed
  const std::string printed = ::testing::internal::GetCapturedStdout();
  EXPECT_EQ(printed, read_bytes(folder / "r/score.json"));
  const nlohmann::json score = nlohmann::json::parse(printed);
  EXPECT_NEAR(score["disparity"]["confident"]["rmse_affine_px"].get<double>(), 0, 1e-6);
  EXPECT_EQ(score["stages"]["merge"]["ms"], 12.5);
}

/// What judges the result r by the capture c.
std::array<std::string, 2> commands_on(const TemporaryFolder& folder) {
  return {fmt::format("score '{}' '{}'", folder / "c", folder / "r"),
          fmt::format("report '{}' --capture '{}' -o '{}'", folder / "r", folder / "c", folder / "page.html")};
}

TEST(ScoreCommand, TakesNoScaleThatIsNoNumber) {
  for (const char* value : {"nan", "inf", "1e308", "x"}) {
    const Outcome outcome = run_command(std::string("score c --disparity d.png --scale ") + value);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("--scale"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("-1e+09 to 1e+09"), std::string::npos) << outcome.err;
  }
}

TEST(ScoreCommand, RefusesAResultOfAnotherCapture) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  write_capture(capture, folder / "c");
  const auto commands = commands_on(folder);
  const auto write_with_hash = [&](const std::string& hash) {
    pipeline::write_result(pipeline::synthetic_result(capture), {{"capture", "elsewhere"}, {"capture_hash", hash}},
                           folder / "r");
  };
  write_with_hash("0123456789abcdef");
  for (const std::string& command : commands) {
    const Outcome outcome = run_command(command);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("elsewhere"), std::string::npos) << outcome.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "r/score.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
  write_with_hash(file_hash(folder / "c/capture.json"));
  for (const std::string& command : commands) EXPECT_EQ(run_command(command).status, 0);
}

TEST(ScoreCommand, TakesAPlainPairOfTheCapturesOwnViewsAlone) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  write_capture(capture, folder / "c");
  const auto commands = commands_on(folder);
  const auto write_of = [&](const std::string& left_hash, const std::string& right_hash) {
    pipeline::write_result(
        pipeline::synthetic_result(capture),
        {{"left", "a.png"}, {"right", "b.png"}, {"left_hash", left_hash}, {"right_hash", right_hash}}, folder / "r");
  };
  const std::string left = file_hash(folder / "c/frames/000_left.png"),
                    right = file_hash(folder / "c/frames/000_right.png");
  for (const std::string& other : {std::string("0123456789abcdef"), left}) {
    write_of(left, other);
    for (const std::string& command : commands) {
      const Outcome outcome = run_command(command);
      expect_one_line_refusal(outcome);
      EXPECT_NE(outcome.err.find("a plain pair, \"a.png\" and \"b.png\""), std::string::npos) << outcome.err;
    }
  }
  write_of(left, right);
  for (const std::string& command : commands) EXPECT_EQ(run_command(command).status, 0);
}

TEST(ScoreCommand, TakesFilesOfAnyProgram) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  write_capture(capture, folder / "c");
  write_npy(folder / "d.npy", capture.truth->disparity_dp_px);
  const Outcome outcome =
      run_command(fmt::format("score '{}' --disparity '{}' --json", folder / "c", folder / "d.npy"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json score = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(score["disparity"]["everything"]["rmse_px"], 0);
  EXPECT_FALSE(score.contains("image"));

  const Outcome refused =
      run_command(fmt::format("score '{0}/none' --disparity '{0}/a.npy' --portrait '{0}/b.png'", folder.path.string()));
  expect_one_line_refusal(refused);
  for (const char* file : {"none", "a.npy", "b.png"}) EXPECT_NE(refused.err.find(file), std::string::npos);
  expect_one_line_refusal(run_command(fmt::format("score '{}'", folder / "c")));
}

// A disparity of integers has a scale, and a confidence of integers is a share of 65535.
TEST(ScoreCommand, ScalesDisparityAlone) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  write_capture(capture, folder / "c");
  const Image& truth = capture.truth->disparity_dp_px;
  ImageU16 steps(truth.width, truth.height), sure(truth.width, truth.height, 1, 65535);
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (std::isfinite(truth.data[i]))
      steps.data[i] = static_cast<std::uint16_t>(std::lround(1000 * (truth.data[i] + 30)));
  }
  write_png16(folder / "d.png", steps);
  write_png16(folder / "c.png", sure);
  write_npy(folder / "d.npy", truth);
  const std::string with_confidence = fmt::format("score '{0}/c' --confidence '{0}/c.png' ", folder.path.string());
  const Outcome outcome = run_command(
      fmt::format("{} --disparity '{}' --scale 0.001 --offset -30 --json", with_confidence, folder / "d.png"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json score = nlohmann::json::parse(outcome.out);
  EXPECT_LE(score["disparity"]["everything"]["rmse_px"].get<double>(), 0.001);
  EXPECT_EQ(score["disparity"]["confident"]["pixels"], score["disparity"]["everything"]["pixels"]);
  const Outcome refused = run_command(with_confidence + "--scale 0.001 --disparity '" + (folder / "d.npy") + "'");
  expect_one_line_refusal(refused);
  EXPECT_NE(refused.err.find("--scale: neither"), std::string::npos) << refused.err;
}

TEST(InfoCommand, KnowsAPortraitResult) {
  const TemporaryFolder folder;
  pipeline::write_result(pipeline::synthetic_result(pipeline::synthetic_capture()), {{"mode", "dp"}}, folder / "r");
  CLI::App program;
  add_info(program);
  ::testing::internal::CaptureStdout();
  program.parse(std::vector<std::string>{"--json", folder / "r", "info"});
  EXPECT_EQ(nlohmann::json::parse(::testing::internal::GetCapturedStdout())["kind"], "portrait result");
}

}  // namespace
}  // namespace dualpixel::tools
