// Bursts that are wrong, given to the program as a user would: one line and status 2, or the documented fallback.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "pipeline/portrait/result_io.h"
#include "simulator/sampling/hash.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

using nlohmann::json;

/// Three frames of random cells, the third of other cells, as if it had moved further than any search reaches, and of
/// less contrast, so that it is not the base.
Capture burst() {
  Capture capture = pipeline::synthetic_capture(128, 96);
  capture.exposure.mosaic_noise = {0.2, 1.5};
  capture.exposure.dp_noise = {0.05, 0.5};
  const auto cells = [](ImageU16& image, std::uint64_t seed) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x)
        image.at(x, y) = 100 + simulator::hash(seed, y / 6, x / 6) % (seed % 2 == 1 ? 250 : 300);
    }
  };
  capture.frames.resize(3, capture.frames.front());
  for (int i = 0; i < 3; ++i) {
    cells(capture.frames[i].mosaic, i == 2);
    cells(capture.frames[i].left, 2 + (i == 2));
    capture.frames[i].right = capture.frames[i].left;
  }
  return capture;
}

class BadBurst : public ::testing::Test {
 protected:
  void SetUp() override { write_capture(burst(), folder / "shot"); }

  Outcome portrait() {
    return run_command("portrait --mode dp '" + (folder / "shot") + "' -o '" + (folder / "out") + "'");
  }

  void edit(const std::function<void(json&)>& change) {
    json document = read_json_file(folder / "shot/capture.json");
    change(document);
    write_bytes(folder / "shot/capture.json", document.dump());
  }

  void expect_refusal(const std::string& word) {
    const Outcome outcome = portrait();
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    EXPECT_EQ(folder.names(), std::set<std::string>{"shot"});
  }

  /// Runs, and what comes out is finite.
  void expect_fallback() {
    const Outcome outcome = portrait();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const pipeline::StoredResult stored = pipeline::read_result(folder / "out");
    for (const Image* image : {&stored.result.input, &stored.result.portrait, &stored.result.disparity_dp_px}) {
      for (const float value : image->data) ASSERT_TRUE(std::isfinite(value));
    }
  }

  TemporaryFolder folder;
};

TEST_F(BadBurst, FrameMissing) {
  std::filesystem::remove(folder / "shot/frames/001_left.png");
  expect_refusal("frames/001_left.png");
}

TEST_F(BadBurst, FrameTruncated) {
  const std::string file = folder / "shot/frames/001_mosaic.png", bytes = read_bytes(file);
  write_bytes(file, bytes.substr(0, bytes.size() / 2));
  expect_refusal("frames/001_mosaic.png");
  edit([](json& d) { d.erase("files"); });
  expect_refusal("frames/001_mosaic.png");
}

TEST_F(BadBurst, FramesOfMixedSizes) {
  write_png16(folder / "shot/frames/002_right.png", ImageU16(64, 23));
  edit([](json& d) { d.erase("files"); });
  expect_refusal("/frames/2/right");
}

TEST_F(BadBurst, FrameWithoutItsMosaic) {
  edit([](json& d) { d["frames"][1].erase("mosaic"); });
  expect_refusal("/frames/1/mosaic");
}

TEST_F(BadBurst, FrameOfNan) {
  const Image nan(64, 24, 1, NAN);
  write_exr(folder / "shot/frames/nan.exr", {{"Y", &nan}}, false);
  edit([](json& d) {
    d.erase("files");
    d["frames"][1]["left"] = "frames/nan.exr";
  });
  expect_refusal("nan.exr");
}

TEST_F(BadBurst, NoFrames) {
  edit([](json& d) { d["frames"] = json::array(); });
  expect_refusal("/frames");
}

// merge.h: a variance below that of rounding is taken as that of rounding
TEST_F(BadBurst, NoiseProfileOfZeroStillMerges) {
  edit([](json& d) { d["exposure"].erase("mosaic_noise"), d["exposure"].erase("dp_noise"); });
  expect_fallback();
}

// align.h: what moved further than the search keeps the base; the third frame is no other than noise to it
TEST_F(BadBurst, MotionBeyondTheSearchKeepsTheBase) {
  expect_fallback();
  const Image input = pipeline::read_result(folder / "out").result.input;
  Capture capture = burst();
  capture.frames.pop_back();
  write_capture(capture, folder / "shot");
  expect_fallback();
  const Image without = pipeline::read_result(folder / "out").result.input;
  double squares = 0;
  for (std::size_t i = 0; i < input.data.size(); ++i) squares += std::pow(input.data[i] - without.data[i], 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(input.data.size())), 0.005);  // the cells' deviation is 0.09
}

}  // namespace
}  // namespace dualpixel::tools
