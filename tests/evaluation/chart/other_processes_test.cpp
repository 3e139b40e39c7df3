// What the chart leaves to other processes: the network in bf16, and Cycles.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/image/resample.h"
#include "capture/json_fields.h"
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
  struct Expected {
    double error, undecided;  // percent: of the union, and of it what rounding to 8 bits may move across .5
  };
  std::vector<Expected> f32;
  for (const int seed : {1, 2}) {
    Image picture(384, 384, 3, 0.2F), truth(384, 384);
    pipeline::draw_face(picture, 150 + 40 * seed, 170, 110);
    for (int y = 100; y < 384; ++y) {
      for (int x = 100; x < 300; ++x) truth.at(x, y) = 1;
    }
    keep_for_bf16(input, seed, picture, truth);
    const Image coarse = pipeline::find_people(picture, {}, network).mask;
    ASSERT_FALSE(coarse.empty());
    const Image mask = resize_bilinear(coarse, 384, 384);
    double undecided = 0, in_union = 0;
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      in_union += mask.data[i] > 0.5F || truth.data[i] > 0.5F ? 1 : 0;
      undecided += std::abs(mask.data[i] - 0.5F) < 0.1F ? 1 : 0;
    }
    f32.push_back({100 * (1 - mask_iou(mask, truth)), 100 * undecided / in_union});
  }
  const Bf16Masks bf16 = try_bf16(input, 2);
  if (!__builtin_cpu_supports("avx512bw")) {
    EXPECT_TRUE(bf16.trials.empty());
    EXPECT_NE(bf16.left_out.find("AVX-512"), std::string::npos);
    return;
  }
  EXPECT_EQ(read_json_file(folder / "bf16/segmentation.json").at("person_network"), "bf16");
  ASSERT_EQ(bf16.trials.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NE(bf16.trials[i].name.find("bf16"), std::string::npos);
    EXPECT_GT(bf16.trials[i].time, 0);
    EXPECT_NEAR(bf16.trials[i].error, f32[i].error, f32[i].undecided);
  }
}

TEST(OtherProcesses, ThatFailAreNamed) {
  const Bf16Masks bf16 = try_bf16({true, "", "", "nowhere", "/bin/false"}, 3);
  EXPECT_TRUE(bf16.trials.empty());
  EXPECT_NE(bf16.left_out, "");
}

/// With a `blender` of ours before all others.
class Cycles : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::getenv("PATH");
    setenv("PATH", (folder_.path.string() + ":" + path_).c_str(), 1);
  }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }
  /// A program that does what `script` says.
  void install_blender(const std::string& script) {
    folder_.write("blender", "#!/bin/sh\n" + script);
    fs::permissions(folder_ / "blender", fs::perms::owner_all);
  }
  ChartInput input() const {
    return {false, "scenes of 'mine'", "", folder_.path.string(), "the program", "the script"};
  }

  const TemporaryFolder folder_;

 private:
  std::string path_;
};

TEST_F(Cycles, PointsAreOfItsMean) {
  install_blender(R"sh(
[ "$#" = 11 ] && [ "$6" = "the script" ] && [ "$8" = "the program" ] && [ "$9" = "scenes of 'mine'/portrait.json" ] || exit 1
shift 9
mkdir "$1"
cat > "$1/cycles.json" <<END
{"mean_nits": {"ours": 200, "cycles": 400}, "difference_of_means": -0.003, "rms_difference": 0.014, "seeds": 3,
 "ours": [{"samples": 64, "cpu_s": 0.5, "cpu_s_standard_error": 0.1, "rmse_nits": 10, "rmse_standard_error": 1}],
 "cycles": [{"samples": 128, "cpu_s": 8, "cpu_s_standard_error": 0.2, "rmse_nits": 4, "rmse_standard_error": 2}]}
END
)sh");
  const ChartPart part = measure_cycles(input());
  ASSERT_EQ(part.sections.size(), 1U);
  EXPECT_TRUE(part.left_out.empty());
  const std::vector<ChartPoint>& points = part.sections[0].points;
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].name, "dualpixel, 64 samples");
  EXPECT_DOUBLE_EQ(points[0].error.value, 5);
  EXPECT_EQ(points[0].time.value, 0.5);
  EXPECT_EQ(points[1].name, "Cycles, 128 samples");
  EXPECT_DOUBLE_EQ(points[1].error.value, 1);
  EXPECT_DOUBLE_EQ(*points[1].error.standard_error, 0.5);
  for (const char* difference : {"-0.30 %", "1.4 %"}) {
    EXPECT_NE(part.sections[0].note.find(difference), std::string::npos) << part.sections[0].note;
  }
}

TEST_F(Cycles, SaysWhyThereIsNothing) {
  ChartInput without = input();
  without.cycles_script.clear();
  EXPECT_NE(measure_cycles(without).left_out.at(0).find("--cycles"), std::string::npos);
  for (const char* script : {"exit 1", "exit 0", "shift 9; mkdir \"$1\"; echo '{\"ours\": [NaN]}' > \"$1/cycles.json\"",
                             "shift 9; echo '{}' > \"$1/cycles.json\""}) {
    install_blender(std::string(script) + "\n");
    const ChartPart part = measure_cycles(input());
    EXPECT_TRUE(part.sections.empty()) << script;
    EXPECT_EQ(part.left_out.size(), 1U) << script;
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
