// `dualpixel scene` as a user gives it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

TEST(SlowSceneCommand, WritesTheSameFilesForAnyThreads) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "4"}) {
    const Outcome outcome =
        run_command("scene chart --seed 9 --set pattern=focus_ladder --set width_px=128 --threads " +
                    std::string(threads) + " -o '" + (folder / threads) + "'");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out + outcome.err, "");
  }
  for (const char* name : {"/scene.json", "/scene.glb"})
    EXPECT_TRUE(read_bytes(folder / "1" + name) == read_bytes(folder / "4" + name)) << name;
  EXPECT_EQ(
      run_command("simulate '" + (folder / "1") + "/scene.json' -o '" + (folder / "capture") + "' --dry-run").status,
      0);
}

TEST(SlowSceneCommand, RefusesInOneLineAndLeavesNothing) {
  const TemporaryFolder folder;
  const std::string to = " -o '" + (folder / "out") + "'";
  for (const char* arguments : {"chart --set distance_m=-1", "chart --set foo=1", "chat", "chart --set burst.frames=0",
                                "chart --set burst.foo=1", "chart --seed -1", "missing.json"}) {
    SCOPED_TRACE(arguments);
    expect_one_line_refusal(run_command(std::string("scene ") + arguments + to));
    EXPECT_TRUE(folder.names().empty());
  }
  expect_one_line_refusal(run_command("scene chart"));
  expect_one_line_refusal(run_command("scene"));
}

TEST(SceneCommand, ListsItsTableAsTextAndJson) {
  const Outcome text = run_command("scene still_life --options");
  EXPECT_NE(text.out.find("distance_m"), std::string::npos);
  EXPECT_EQ(text.out.find("siemens_star"), std::string::npos);
  const nlohmann::json all = nlohmann::json::parse(run_command("scene --options --json").out);
  EXPECT_EQ(all.size(), 5U);
  EXPECT_EQ(all[0]["parameters"][0]["name"], "width_px");
}

TEST(SceneCommand, ReadsDefinitions) {
  const TemporaryFolder folder;
  write_bytes(
      folder / "star.json",
      R"({"kind": "chart", "title": "t", "seed": 4, "set": {"pattern": "siemens_star", "width_px": 128, "lens.f_number": 2.2, "lens": "phone_thin"}})");
  const Outcome outcome = run_command("scene '" + (folder / "star.json") + "' -o '" + (folder / "out") + "'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json scene = nlohmann::json::parse(read_bytes(folder / "out" + "/scene.json"));
  EXPECT_EQ(scene["lens"]["f_number"], 2.2);
  EXPECT_EQ(scene["render"]["seed"], 4);
  write_bytes(folder / "bad.json", R"({"kind": "chart", "sed": 4})");
  expect_one_line_refusal(run_command("scene '" + (folder / "bad.json") + "' -o '" + (folder / "out2") + "'"));
}

}  // namespace
}  // namespace dualpixel
