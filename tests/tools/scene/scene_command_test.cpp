// `dualpixel scene` as a user gives it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/scenes/people/makehuman_assets.h"
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
  EXPECT_EQ(all[0]["parameters"][0]["step"], 16);
  EXPECT_NE(text.out.find("8192, by 16"), std::string::npos);
}

TEST(SceneCommand, KeepsTheColumnsOfItsTableApart) {
  std::istringstream lines(run_command("scene chart --options").out);  // whose patterns make a long list
  std::string title, header;
  std::getline(lines, title);
  std::getline(lines, header);
  for (const char* column : {"allowed", "default", "unit", "meaning"}) {
    const std::size_t start = header.find(column);
    ASSERT_NE(start, std::string::npos);
    std::istringstream rows(lines.str());
    for (std::string row; std::getline(rows, row);) {
      if (row == title) continue;
      EXPECT_EQ(row.substr(start - 2, 2), "  ") << row;
    }
  }
}

TEST(SceneCommand, RefusesWrongFoldersAndFields) {
  for (const char* wrong :
       {"makehuman=/no/such/folder: must be a folder", "lens.f_number=-1: must be", "lens.f_numbr=2: unknown field"}) {
    const std::string text = wrong;
    const Outcome refused =
        run_command("scene portrait --seed 1 --set " + text.substr(0, text.find(':')) + " -o never");
    expect_one_line_refusal(refused);
    EXPECT_NE(refused.err.find(text.substr(text.find(": "))), std::string::npos) << refused.err;
  }
}

TEST(SlowSceneCommand, PeopleOfMakeHumansAssetsAreAnotherPortrait) {
  const TemporaryFolder folder;
  const TemporaryFolder assets;
  scenes::write_makehuman(assets, scenes::smallest_body(), R"({"weights": {"head": [[0, 1.0]]}})");
  scenes::write_targets(assets, "");
  const auto draw = [&](const std::string& name, const std::string& more) {
    return run_command("scene portrait --seed 3 --set people=1 --set width_px=128 " + more + " -o '" + (folder / name) +
                       "'");
  };
  const Outcome made = draw("assets", "--set 'makehuman=" + assets.path.string() + "'");
  ASSERT_EQ(made.status, 0) << made.err;
  ASSERT_EQ(draw("drawn", "").status, 0);
  EXPECT_NE(read_bytes(folder / "assets" + "/scene.glb"), read_bytes(folder / "drawn" + "/scene.glb"));
  const Outcome missing = draw("missing", "--set makehuman=/no/such/folder");
  expect_one_line_refusal(missing);
  EXPECT_NE(missing.err.find("portrait: makehuman: /no/such/folder: must be a folder"), std::string::npos)
      << missing.err;
  const TemporaryFolder empty;
  const Outcome bare = draw("missing", "--set 'makehuman=" + empty.path.string() + "'");
  expect_one_line_refusal(bare);
  EXPECT_NE(bare.err.find("portrait: makehuman: " + empty.path.string()), std::string::npos) << bare.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "missing"));
  EXPECT_NE(run_command("scene portrait --options").out.find("makehuman"), std::string::npos);
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
  for (const std::string& wrong :
       {"simulate '" + (folder / "star.json"), "scene '" + (folder / "out" + "/scene.json")}) {
    const Outcome refused = run_command(wrong + "' -o '" + (folder / "out2") + "'");
    expect_one_line_refusal(refused);
    const std::string rather = wrong.starts_with("scene") ? "dualpixel simulate" : "dualpixel scene";
    EXPECT_NE(refused.err.find(rather), std::string::npos) << refused.err;
  }
  for (const char* bad : {R"({"kind": "chart", "sed": 4})", R"({"kind": "chat"})",
                          R"({"kind": "chart", "set": {"foo": 1}})", R"({"kind": "chart", "set": {"width_px": 3}})"}) {
    SCOPED_TRACE(bad);
    write_bytes(folder / "bad.json", bad);
    const Outcome refused = run_command("scene '" + (folder / "bad.json") + "' -o '" + (folder / "out2") + "'");
    expect_one_line_refusal(refused);
    EXPECT_NE(refused.err.find("bad.json"), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace dualpixel
