#include "datasets/plan/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <map>
#include <set>

#include "capture/error.h"
#include "tests/datasets/small_recipe.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;
using testing::small_recipe;

std::vector<std::string> texts(const Plan& plan) {
  std::vector<std::string> all;
  for (const SampleLine& line : plan.lines) all.push_back(to_text(line));
  return all;
}

Plan plan_of(const json& recipe) { return make_plan(read_recipe(recipe, "r.json")); }

json of_charts(int count, int seeds) {
  json recipe = small_recipe(count);
  recipe["scenes"] = {{{"kind", "chart"}, {"seeds", {1, seeds}}, {"set", {{"width_px", 128}}}}};
  recipe["set"] = json::object();
  recipe["split"] = {{"train", 0.6}, {"validation", 0.1}, {"test", 0.3}};
  return recipe;
}

TEST(Plan, LinesHangOnTheirIndexAlone) {
  const std::vector<std::string> few = texts(plan_of(small_recipe(7))), many = texts(plan_of(small_recipe(40)));
  ASSERT_EQ(many.size(), 40U);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
  EXPECT_EQ(std::set<std::string>(many.begin(), many.end()).size(), 40U);
  json other = small_recipe(7);
  other["seed"] = 6;
  EXPECT_NE(texts(plan_of(other)), few);
}

TEST(Plan, LinesAreReadAsTheyWereWritten) {
  for (const std::string& text : texts(plan_of(small_recipe()))) {
    EXPECT_EQ(to_text(read_sample_line(text, "line")), text);
  }
}

TEST(Plan, SplitsShareNoSceneAndHaveTheirShares) {
  constexpr int kCount = 400;
  const Plan plan = plan_of(of_charts(kCount, 20));
  std::map<json, std::set<Split>> splits;
  std::map<json, int> counts;
  for (const SampleLine& line : plan.lines) {
    splits[line.scene].insert(line.split);
    ++counts[line.scene];
  }
  EXPECT_EQ(splits.size(), 20U);
  for (const auto& [scene, in] : splits) EXPECT_EQ(in.size(), 1U) << scene;
  // The discrepancy of the golden ratio's sequence of n points is below 1 + 1.5 log2(n) points (Niederreiter 1992).
  const double off = 1 + 1.5 * std::log2(kCount);
  EXPECT_NEAR(static_cast<double>(plan.samples[0]), 0.6 * kCount, off);
  EXPECT_NEAR(static_cast<double>(plan.samples[1]), 0.1 * kCount, off);
  EXPECT_EQ(plan.scenes, (std::array<std::size_t, 3>{12, 2, 6}));
}

TEST(Plan, CopiesOfAModelAreInOneSplit) {
  const TemporaryFolder folder;
  const std::string glb = read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb");
  for (const char* name : {"a.glb", "b.glb", "deep/c.glb"}) folder.write(name, glb);
  folder.write("other.glb", read_bytes(DUALPIXEL_SCENES_DIR "/occlusion_edges.glb"));
  folder.write("a.json", R"({"version": 1, "gltf": "a.glb"})");
  json recipe = small_recipe(64);
  recipe["scenes"] = {{{"folder", folder.path.string()}}};
  recipe["split"] = {{"train", 0.5}, {"test", 0.5}};
  std::set<std::string> train, test;
  for (const SampleLine& line : plan_of(recipe).lines) {
    (line.split == Split::train ? train : test).insert(line.scene["file"].get<std::string>());
  }
  std::set<std::string>& copies = train.size() == 3 ? train : test;
  EXPECT_EQ(copies, (std::set<std::string>{folder / "a.json", folder / "b.glb", folder / "deep/c.glb"}));
  EXPECT_EQ(train.size() + test.size(), 4U);
}

TEST(Plan, GridsRunThroughAllCombinations) {
  json recipe = small_recipe(12);
  recipe["set"]["exposure.iso"] = {{"grid", {100, 200, 400}}};
  recipe["set"]["lens.f_number"] = {{"grid", {1.8, 2.8}}};
  std::map<std::pair<int, double>, int> seen;
  for (const SampleLine& line : plan_of(recipe).lines) {
    ++seen[{line.set["exposure.iso"].get<int>(), line.set["lens.f_number"].get<double>()}];
  }
  EXPECT_EQ(seen.size(), 6U);
  for (const auto& [values, count] : seen) EXPECT_EQ(count, 2);
}

TEST(Plan, ModelSizeIsAScenesOwn) {
  json recipe = small_recipe(20);
  recipe["relations"]["model_size_m"] = {{"log_uniform", {0.3, 2}}};
  std::map<json, std::set<double>> sizes;
  for (const SampleLine& line : plan_of(recipe).lines) sizes[line.scene].insert(line.set["model_size_m"].get<double>());
  ASSERT_EQ(sizes.size(), 2U);
  for (const auto& [scene, size] : sizes) EXPECT_EQ(size.size(), 1U);
}

TEST(Plan, StatesItsBytes) {
  // left and right 32 x 12, disparity likewise, depth 64 x 48, 4 bytes each
  EXPECT_EQ(plan_of(small_recipe()).bytes_per_sample, 4 * (3 * 32 * 12 + 64 * 48));
  json recipe = small_recipe();
  recipe.erase("keep");
  recipe["layout"] = "dpdd";
  recipe["set"]["sensor.dp_downsample_x"] = recipe["set"]["sensor.dp_downsample_y"] = 1;
  EXPECT_EQ(plan_of(recipe).bytes_per_sample, 4 * 6 * 64 * 48);
}

TEST(Plan, WarnsOfWhatIsSeldomMeant) {
  json recipe = small_recipe();
  EXPECT_FALSE(plan_of(recipe).warning);
  recipe["set"]["camera.file"] = DUALPIXEL_SCENES_DIR "/cameras/phone_2019.json";
  const std::optional<std::string> warning = plan_of(recipe).warning;
  ASSERT_TRUE(warning);
  EXPECT_TRUE(warning->starts_with("r.json: 6 of 6 samples, the first is 0: ")) << *warning;
  EXPECT_NE(warning->find("/lens: hides the lens of "), std::string::npos) << *warning;
  recipe["set"]["lens"] = nullptr;
  EXPECT_FALSE(plan_of(recipe).warning);
}

TEST(Plan, RefusesBeforeAnythingIsRendered) {
  const auto refusal = [](const std::string& pointer, const json& value) {
    json recipe = small_recipe();
    recipe[json::json_pointer(pointer)] = value;
    return message_of<InputError>([&] { plan_of(recipe); });
  };
  EXPECT_TRUE(refusal("/set/lens.f_number", {{"uniform", {-2, -1}}}).starts_with("r.json: sample 0: "));
  EXPECT_NE(refusal("/set/lens.f_number", -2).find("f_number: -2: must be a number in [0.1, 1000]"), std::string::npos);
  EXPECT_NE(refusal("/set/lens.f_numbr", 2).find("did you mean 'f_number'?"), std::string::npos);
  EXPECT_EQ(refusal("/keep/0", "lef"),
            "r.json: /keep: lef: must be one of 'left', 'right', 'combined', 'raw', "
            "'left_noiseless', 'right_noiseless', 'left_rgb', 'right_rgb', 'all_in_focus', "
            "'photograph', 'depth_m', 'blur_px', 'disparity_dp_px', 'normal', 'person', "
            "'valid', 'object_id', 'view_depth_m', 'view_blur_px', 'view_disparity_dp_px', "
            "'view_normal', 'view_person', 'view_valid', 'view_object_id'; did you mean "
            "'left'?");
  EXPECT_EQ(refusal("/set/camera.focus_distance_m", 1),
            "r.json: /set/camera.focus_distance_m: follows from /relations/focus: give one of them");
  EXPECT_EQ(refusal("/set/render.seed", 1),
            "r.json: /set/render.seed: each sample has a seed of its own: leave it out");
  EXPECT_EQ(refusal("/split", {{"train", 0.5}}),
            "r.json: /split/train: the shares of train, validation and test add up to 0.5: must be 1");
  EXPECT_EQ(refusal("/split", {{"train", 0.4}, {"validation", 0.3}, {"test", 0.3}}),
            "r.json: /scenes: 2 different files or seeds: must be 3 at least, one for each split of /split");
  EXPECT_EQ(refusal("/count", 0), "r.json: /count: 0: must be an integer in [1, 10000000]");
  EXPECT_EQ(refusal("/scenes/0", {{"kind", "chart"}, {"seeds", {3, 1}}}),
            "r.json: /scenes/0/seeds: [3,1]: must be [first, last], whole numbers in [0, 1e15], at most 10000000 of "
            "them");
  EXPECT_EQ(refusal("/scenes/1", {{"kind", "chart"}, {"seeds", {1, 3}}, {"set", {{"width_px", 64}}}}),
            "r.json: /scenes/1: chart: width_px: 64: must be a multiple of 16 in [128, 8192] photosites");
  EXPECT_EQ(refusal("/scenes/1", {{"file", "/none.json"}}), "r.json: /scenes/1: /none.json: no such file");
}

TEST(Recipe, NamesFilesBesideItself) {
  json recipe = small_recipe();
  for (const char* field : {"lens.file", "camera.file", "environment.path"}) {
    recipe["set"][field] = "../files/a.json";
    EXPECT_EQ(read_recipe(recipe, "/sets/new/r.json").set.at(field).values.front(), "/sets/files/a.json");
  }
}

TEST(Plan, StaysAsItWasWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "set";
  const Recipe recipe = read_recipe(small_recipe(), "r.json");
  write_plan(make_plan(recipe), recipe, path);
  const std::string written = read_bytes(path + "/plan.jsonl");
  EXPECT_EQ(read_plan(path).size(), 6U);
  write_plan(make_plan(recipe), recipe, path);  // the same: stays
  const Recipe longer = read_recipe(small_recipe(7), "r.json");
  EXPECT_EQ(message_of<InputError>([&] { write_plan(make_plan(longer), longer, path); }),
            path + ": holds another plan, which may not change: choose another folder");
  EXPECT_EQ(read_bytes(path + "/plan.jsonl"), written);
  write_bytes(path + "/plan.jsonl", written.substr(1));
  EXPECT_EQ(message_of<InputError>([&] { read_plan(path); }),
            path + "/plan.jsonl: was changed since it was planned: plan again into another folder");
}

TEST(Plan, SplitsGetWholeThings) {
  using Counts = std::array<std::size_t, 3>;
  EXPECT_EQ(split_counts(10, {0.8, 0.1, 0.1}), (Counts{8, 1, 1}));
  EXPECT_EQ(split_counts(3, {0.8, 0.1, 0.1}), (Counts{1, 1, 1}));
  EXPECT_EQ(split_counts(5, {0.5, 0, 0.5}), (Counts{2, 0, 3}));
  EXPECT_EQ(split_counts(1, {1, 0, 0}), (Counts{1, 0, 0}));
}

TEST(SlowPlan, TenThousandLinesInTenCpuSeconds) {
  const std::clock_t begin = std::clock();
  plan_of(of_charts(10000, 100));
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 10);
}

}  // namespace
}  // namespace dualpixel::datasets
