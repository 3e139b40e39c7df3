#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

TEST(ExperimentStages, WritesTheRowsThatWereAskedFor) {
  const TemporaryFolder folder;
  const std::string out = folder / "stages";
  const Outcome made = run_command("experiment stages --row weak_edges --row two_depths --draws 1 -o '" + out + "'");
  ASSERT_EQ(made.status, 0) << made.err;
  const nlohmann::json json = nlohmann::json::parse(read_file(out + "/stages.json"));
  ASSERT_EQ(json["rows"].size(), 2u);
  EXPECT_EQ(json["rows"][0]["name"], "weak_edges");
  EXPECT_NE(read_file(out + "/stages.html").find("id=\"two_depths\""), std::string::npos);
}

TEST(ExperimentStages, RefusesAnUnknownRowBeforeItWrites) {
  const TemporaryFolder folder;
  const std::string out = folder / "stages";
  const Outcome refused = run_command("experiment stages --row weak_egdes -o '" + out + "'");
  expect_one_line_refusal(refused);
  EXPECT_NE(refused.err.find("did you mean 'weak_edges'?"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace dualpixel
