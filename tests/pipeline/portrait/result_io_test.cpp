#include "pipeline/portrait/result_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"

namespace dualpixel::pipeline {
namespace {

/// Half floats keep 11 bits.
void expect_half_equal(const Image& read, const Image& written) {
  ASSERT_TRUE(read.same_size(written));
  ASSERT_EQ(read.channels, written.channels);
  for (std::size_t i = 0; i < read.data.size(); ++i) {
    ASSERT_NEAR(read.data[i], written.data[i], std::abs(written.data[i]) / 2048);
  }
}

TEST(ResultIo, ReadsWhatWasWritten) {
  const TemporaryFolder folder;
  PortraitResult written = synthetic_result(synthetic_capture());
  written.matched_sigma_dp_px = written.matched_confidence;
  written.matched_sigma_dp_px.at(1, 2) = 0.125f;
  write_result(written, {{"mode", "dp"}, {"capture", "some\nwhere"}}, folder / "r");
  const StoredResult stored = read_result(folder / "r");
  const PortraitResult& read = stored.result;
  expect_half_equal(read.input, written.input);
  expect_half_equal(read.portrait, written.portrait);
  for (std::size_t i = 0; i < written.portrait_srgb.data.size(); ++i) {
    ASSERT_NEAR(read.portrait_srgb.data[i], written.portrait_srgb.data[i], 0.51 / 255);
  }
  EXPECT_EQ(read.disparity_dp_px.data, written.disparity_dp_px.data);
  EXPECT_EQ(read.confidence.data, written.confidence.data);
  EXPECT_EQ(read.blur_radius_px.data, written.blur_radius_px.data);
  EXPECT_EQ(read.matched_disparity_dp_px.data, written.matched_disparity_dp_px.data);
  EXPECT_EQ(read.matched_confidence.data, written.matched_confidence.data);
  EXPECT_EQ(read.matched_sigma_dp_px.data, written.matched_sigma_dp_px.data);
  EXPECT_TRUE(read.mask.empty());
  EXPECT_EQ(read.focus_disparity_dp_px, -0.125);
  ASSERT_EQ(read.stages.size(), 2u);
  EXPECT_EQ(read.stages[1].name, "blur");
  EXPECT_EQ(read.stages[1].ms, 20.25);
  EXPECT_EQ(read.stages[1].peak_rss_mb, 350);
  EXPECT_EQ(stored.json["provenance"]["capture"], "some\nwhere");
}

TEST(ResultIo, KeepsNaN) {
  const TemporaryFolder folder;
  PortraitResult written = synthetic_result(synthetic_capture());
  written.disparity_dp_px.at(3, 4) = NAN;
  write_result(written, {{"mode", "dp"}}, folder / "r");
  const PortraitResult read = read_result(folder / "r").result;
  EXPECT_TRUE(std::isnan(read.disparity_dp_px.at(3, 4)));
  EXPECT_TRUE(read.matched_sigma_dp_px.empty());  // as the paper's matcher leaves it
}

TEST(ResultIo, OfTheMaskAloneHasNoDisparity) {
  const TemporaryFolder folder;
  PortraitResult written = synthetic_result(synthetic_capture());
  written.mask = written.confidence;
  written.disparity_dp_px = written.confidence = written.matched_disparity_dp_px = written.matched_confidence = {};
  write_result(written, {{"mode", "seg"}}, folder / "r");
  const PortraitResult read = read_result(folder / "r").result;
  EXPECT_TRUE(read.disparity_dp_px.empty());
  EXPECT_TRUE(read.matched_disparity_dp_px.empty());
  EXPECT_EQ(read.mask.data, written.mask.data);
}

TEST(ResultIo, ReplacesAResultAndNothingElse) {
  const TemporaryFolder folder;
  const PortraitResult result = synthetic_result(synthetic_capture());
  write_result(result, {{"mode", "dp"}}, folder / "r");
  write_bytes(folder / "r/score.json", "{}");
  write_result(result, {{"mode", "dp"}}, folder / "r");
  EXPECT_FALSE(std::filesystem::exists(folder / "r/score.json"));  // the old result's
  std::filesystem::create_directory(folder / "mine");
  write_bytes(folder / "mine/letter.txt", "dear");
  EXPECT_THROW(write_result(result, {{"mode", "dp"}}, folder / "mine"), InputError);
  EXPECT_EQ(read_bytes(folder / "mine/letter.txt"), "dear");
  EXPECT_EQ(folder.names(), (std::set<std::string>{"mine", "r"}));
}

TEST(ResultIo, RefusesWhatIsMissingOrDoesNotFit) {
  const TemporaryFolder folder;
  const std::string path = folder / "r";
  const auto message = [&] { return message_of<InputError>([&] { read_result(path); }); };
  EXPECT_EQ(message(), path + "/result.json: no such file");
  const auto renew = [&] { write_result(synthetic_result(synthetic_capture()), {{"mode", "dp"}}, path); };

  renew();
  std::filesystem::remove(path + "/portrait.exr");
  EXPECT_EQ(message(), path + "/portrait.exr: no such file");

  renew();
  std::filesystem::remove(path + "/maps.exr");
  EXPECT_EQ(message(), path + "/maps.exr: is missing, which /provenance/mode \"dp\" makes");

  for (const nlohmann::json& mode : {nlohmann::json("q"), nlohmann::json("auto"), nlohmann::json(3)}) {
    write_result(synthetic_result(synthetic_capture()), {{"mode", mode}}, path);
    EXPECT_EQ(message(),
              path + "/result.json: /provenance/mode: " + mode.dump() + ": must be \"dp\", \"dp+seg\" or \"seg\"");
  }

  renew();
  const Image small(8, 8, 3);
  write_png8(path + "/portrait.png", small);
  EXPECT_EQ(message(), path + "/portrait.png: 8 x 8 pixels; input.exr has 64 x 48");

  renew();
  const Image other(64, 48);
  write_exr(path + "/maps.exr", {{"confidence", &other}}, false);
  EXPECT_EQ(message(), path + "/maps.exr: disparity_dp_px and confidence must come together");

  write_exr(path + "/maps.exr", {{"mask", &other}}, false);
  EXPECT_EQ(message(), path + "/maps.exr: lacks disparity_dp_px, which /provenance/mode \"dp\" makes");
  write_exr(path + "/maps.exr", {{"unknown", &other}}, false);
  EXPECT_EQ(message(), path + "/maps.exr: holds none of the maps of a result");

  renew();
  write_bytes(path + "/result.json", R"({"format": "dualpixel-result", "version": 2, "provenance": {}, "stages": []})");
  EXPECT_NE(message().find("/version: 2"), std::string::npos) << message();
  write_bytes(path + "/result.json", R"({"format": "dualpixel-result", "version": 1, "provenance": {}, "stages": 3})");
  EXPECT_NE(message().find("/stages"), std::string::npos) << message();
  write_bytes(path + "/result.json", R"({"format": "dualpixel-result", "version": 1, "stages": []})");
  EXPECT_NE(message().find("/provenance"), std::string::npos) << message();
}

}  // namespace
}  // namespace dualpixel::pipeline
