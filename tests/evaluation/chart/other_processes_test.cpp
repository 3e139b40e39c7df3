// What the chart leaves to other processes: the network in bf16, and Cycles.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "capture/image/resample.h"
#include "evaluation/chart/bf16_masks.h"
#include "evaluation/chart/cycles_stage.h"
#include "evaluation/metrics/mask_metrics.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;

TEST(SlowOtherProcesses, FindPeopleInBf16) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  const TemporaryFolder folder;
  const ChartInput input{true, "", "", folder.path.string(), DUALPIXEL_PROGRAM};
  pipeline::PersonNetwork network;
  std::vector<double> f32;
  for (const int seed : {1, 2}) {
    Image picture(384, 384, 3, 0.2F), truth(384, 384);
    pipeline::draw_face(picture, 150 + 40 * seed, 170, 110);
    for (int y = 100; y < 384; ++y) {
      for (int x = 100; x < 300; ++x) truth.at(x, y) = 1;
    }
    keep_for_bf16(input, seed, picture, truth);
    const Image mask = pipeline::find_people(picture, {}, network).mask;
    ASSERT_FALSE(mask.empty());
    f32.push_back(100 * (1 - mask_iou(resize_bilinear(mask, 384, 384), truth)));
  }
  const std::vector<Trial> bf16 = try_bf16(input, 2);
  if (!__builtin_cpu_supports("avx512bw")) {
    EXPECT_TRUE(bf16.empty());
    return;
  }
  ASSERT_EQ(bf16.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NE(bf16[i].name.find("bf16"), std::string::npos);
    EXPECT_GT(bf16[i].time, 0);
    EXPECT_NE(bf16[i].error, f32[i]);  // 8 bits of mantissa in place of 24
    EXPECT_NEAR(bf16[i].error, f32[i], 1);
  }
}

TEST(OtherProcesses, NoProgramNoFigures) {
  EXPECT_TRUE(try_bf16({true, "", "", "nowhere", ""}, 3).empty());
  EXPECT_TRUE(try_bf16({true, "", "", "nowhere", "/bin/false"}, 3).empty());
}

/// In the sources' folder, with a `blender` of ours before all others.
class Cycles : public testing::Test {
 protected:
  void SetUp() override {
    before_ = fs::current_path();
    fs::current_path(DUALPIXEL_SOURCE_DIR);
    path_ = std::getenv("PATH");
    setenv("PATH", (folder_.path.string() + ":" + path_).c_str(), 1);
  }
  void TearDown() override {
    fs::current_path(before_);
    setenv("PATH", path_.c_str(), 1);
  }
  /// A program that does what `script` says.
  void install_blender(const std::string& script) {
    folder_.write("blender", "#!/bin/sh\n" + script);
    fs::permissions(folder_ / "blender", fs::perms::owner_all);
  }
  ChartInput input() const { return {false, "scenes of 'mine'", "", folder_.path.string(), "the program"}; }

  const TemporaryFolder folder_;

 private:
  fs::path before_;
  std::string path_;
};

TEST_F(Cycles, PointsAreOfItsMean) {
  install_blender(R"sh(
[ "$#" = 10 ] && [ "$7" = "the program" ] && [ "$8" = "scenes of 'mine'/portrait.json" ] && mkdir "$9" || exit 1
cat > "$9/cycles.json" <<END
{"mean_nits": {"ours": 200, "cycles": 400}, "difference_of_means": -0.003,
 "ours": [{"samples": 64, "cpu_s": 0.5, "rmse_nits": 10}], "cycles": [{"samples": 128, "cpu_s": 8, "rmse_nits": 4}]}
END
)sh");
  EXPECT_TRUE(can_measure_cycles());
  const ChartPart part = measure_cycles(input());
  ASSERT_EQ(part.sections.size(), 1U);
  const std::vector<ChartPoint>& points = part.sections[0].points;
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].name, "dualpixel, 64 samples");
  EXPECT_DOUBLE_EQ(points[0].error.value, 5);
  EXPECT_EQ(points[0].time.value, 0.5);
  EXPECT_EQ(points[1].name, "Cycles, 128 samples");
  EXPECT_DOUBLE_EQ(points[1].error.value, 1);
  EXPECT_NE(part.sections[0].note.find("-0.30 %"), std::string::npos) << part.sections[0].note;
}

TEST_F(Cycles, GivesNothingWhereItFails) {
  install_blender("exit 1\n");
  EXPECT_TRUE(can_measure_cycles());
  EXPECT_TRUE(measure_cycles(input()).sections.empty());
  fs::current_path(folder_.path);  // without the script
  EXPECT_FALSE(can_measure_cycles());
}

}  // namespace
}  // namespace dualpixel::evaluation
