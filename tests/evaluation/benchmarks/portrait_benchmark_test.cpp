#include "evaluation/benchmarks/portrait_benchmark.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pipeline/segmentation/network.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kFacePicture = 320;

Capture capture_of_a_face() {
  Image picture(kFacePicture, kFacePicture, 1, 0.2F);
  pipeline::draw_face(picture, 150, 150, 110);
  Capture capture = pipeline::synthetic_capture(kFacePicture, kFacePicture);
  ImageU16& mosaic = capture.frames[0].mosaic;
  for (std::size_t i = 0; i < mosaic.data.size(); ++i) {
    mosaic.data[i] = static_cast<std::uint16_t>(64 + (1023 - 64) * picture.data[i]);
  }
  return capture;
}

TEST(SlowPortraitBenchmark, RowsAddUpToTheTotal) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  const TemporaryFolder folder;
  write_capture(capture_of_a_face(), folder / "face");
  write_capture(pipeline::synthetic_capture(kFacePicture, kFacePicture), folder / "nobody");
  const PortraitBenchmark benchmark = measure_portraits({folder / "face", folder / "nobody"}, "paper");
  EXPECT_EQ(benchmark.captures, 2U);
  EXPECT_EQ(benchmark.with_people, 1U);
  for (std::size_t mode = 0; mode < 3; ++mode) {
    double sum = 0;
    for (const TableFourRow& row : benchmark.rows) {
      if (!row.ours[mode] || row.name == "total") continue;
      EXPECT_GT(row.ours[mode]->mean_ms, 0) << row.name;
      sum += row.ours[mode]->mean_ms;
    }
    ASSERT_EQ(benchmark.rows.back().name, "total");
    EXPECT_NEAR(sum, benchmark.rows.back().ours[mode]->mean_ms, 1e-9 * sum);
    EXPECT_EQ(benchmark.rows.back().ours[mode]->sigma_ms > 0, mode == 0);  // of one capture there is none
  }
  // every part that the paper counts in a mode is measured there
  for (const TableFourRow& row : benchmark.rows) {
    for (std::size_t mode = 0; mode < 3; ++mode) {
      EXPECT_TRUE(row.ours[mode] || !row.paper_ms[mode]) << row.name << ' ' << kTableFourModes[mode];
    }
  }
  EXPECT_EQ(to_json(benchmark).at("rows").at(4).at("modes").at("dp").at("paper_ms"), 1241);
  EXPECT_TRUE(to_text(benchmark).starts_with("2 captures (320 x 320, 1 frames), people found in 1; matcher paper, "))
      << to_text(benchmark);
}

}  // namespace
}  // namespace dualpixel::evaluation
