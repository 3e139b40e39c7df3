#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "tests/pipeline/ramp_pair.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

std::string write_pair(const TemporaryFolder& folder) {
  const pipeline::RampPair pair = pipeline::ramp_pair(1, 6, 0.003, pipeline::kRampAlpha, 1, 96, 64);
  for (const auto& [name, view] : {std::pair{"l.png", &pair.left}, {"r.png", &pair.right}}) {
    Image encoded = *view;
    for (float& value : encoded.data) value = srgb_from_linear(value);
    write_png8(folder / name, encoded);
  }
  return "portrait --left '" + (folder / "l.png") + "' --right '" + (folder / "r.png") + "' -o '" + (folder / "out") +
         "' ";
}

TEST(PortraitAuto, ChoosesByTimeOrError) {
  struct Case {
    const char *option, *matcher, *said;
  };
  for (const auto& [option, matcher, said] :
       {Case{"--auto 1000 --set split_match.alpha=.3", "split",
             "--auto: split, 1/4 (--matcher split): some 7.8 ms of CPU time"},
        Case{"--auto .4 --set split_match.alpha=.3", "paper",
             "--auto: paper, 1/16 (--matcher paper --set smooth.divisor=16 "},
        Case{"--auto-error .8 --zoom", "likelihood",
             "some 0.3 ms of CPU time for disparity, at most 0.75 DP px on charted"}}) {
    const TemporaryFolder folder;
    const Outcome outcome = run_command(write_pair(folder) + "--mode dp " + option);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
    const nlohmann::json result = read_json_file(folder / "out/result.json");
    EXPECT_EQ(result["provenance"]["matcher"], matcher);
    EXPECT_TRUE(result["provenance"]["auto"].contains("charted_cpu_ms")) << result["provenance"].dump();
  }
}

TEST(PortraitAuto, RefusesWhatItCannotKeep) {
  const TemporaryFolder folder;
  const std::string portrait = write_pair(folder);
  for (const auto& [options, said] :
       {std::pair{"--auto .01", "--auto 0.01: must be at least 0.3, ms of the fastest setting for 0.00614 megapixels"},
        {"--auto nan", "--auto: Value nan not in range 0.001 to 1e+09"},
        {"--auto ''", "--auto: Value  not in range"},
        {"--auto-error .1", "--auto-error 0.1: must be at least 0.245, DP px of the most accurate setting on offer"},
        {"--auto 100 --auto-error 1", "--auto excludes --auto-error"},
        {"--auto 100 --matcher split", "--matcher excludes --auto"},
        {"--auto 100 --disparity d.npy", "--auto excludes --disparity"},
        {"--auto 100 --set smooth.divisor=8", "--set smooth.divisor=8: smoothing is chosen by --auto"},
        {"--auto 100 --tap 999,9", "--tap"},
        {"--auto 100 --mode seg", "--auto: chooses how disparity is found, which mode seg does not use"}}) {
    const Outcome outcome = run_command(portrait + options);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
  }
  write_png8(folder / "photo.png", Image(64, 64, 3, 0.5f));
  const Outcome photograph =
      run_command("portrait '" + (folder / "photo.png") + "' -o '" + (folder / "out") + "' --auto 100");
  expect_one_line_refusal(photograph);
  EXPECT_NE(photograph.err.find("--auto: "), std::string::npos) << photograph.err;
  EXPECT_NE(photograph.err.find("cannot be used with a photograph"), std::string::npos) << photograph.err;
}

}  // namespace
}  // namespace dualpixel::tools
