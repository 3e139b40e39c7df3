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
       {Case{"--auto 1000", "split", "--auto: split, 1/8: 0.252 ms of CPU time for disparity and 0.22 DP px"},
        Case{"--auto .16", "paper", "--auto: paper, 1/16: 0.147 ms of CPU time"},
        Case{"--auto-error .6", "likelihood", "--auto-error: likelihood, 1/32: 0.184 ms of CPU time"}}) {
    const TemporaryFolder folder;
    const Outcome outcome = run_command(write_pair(folder) + "--mode dp " + option);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
    const nlohmann::json result = read_json_file(folder / "out/result.json");
    EXPECT_EQ(result["provenance"]["matcher"], matcher);
    EXPECT_TRUE(result["provenance"]["options"].contains("smooth.divisor")) << result["provenance"].dump();
  }
}

TEST(PortraitAuto, RefusesWhatItCannotKeep) {
  const TemporaryFolder folder;
  const std::string portrait = write_pair(folder);
  for (const auto& [options, said] :
       {std::pair{"--auto .01", "--auto 0.01: the fastest setting takes 0.147 ms for 0.00614 megapixels; allow that"},
        {"--auto nan", "--auto"},
        {"--auto-error .1", "--auto-error 0.1: the least error of any setting is 0.22 DP px; allow that"},
        {"--auto 100 --auto-error 1", "--auto-error"},
        {"--auto 100 --matcher split", "--matcher"},
        {"--auto 100 --set smooth.divisor=8", "--set smooth.divisor: is chosen by --auto; leave one of them out"},
        {"--auto 100 --mode seg", "--auto: chooses how disparity is found, which mode seg does not use"}}) {
    const Outcome outcome = run_command(portrait + options);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
  }
  write_png8(folder / "photo.png", Image(64, 64, 3, 0.5f));
  const Outcome photograph =
      run_command("portrait '" + (folder / "photo.png") + "' -o '" + (folder / "out") + "' --auto 100");
  expect_one_line_refusal(photograph);
  EXPECT_NE(photograph.err.find("--auto"), std::string::npos) << photograph.err;
}

}  // namespace
}  // namespace dualpixel::tools
