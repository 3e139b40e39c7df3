// `dualpixel dataset` as a user gives it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/datasets/small_recipe.h"
#include "tests/run_program.h"

namespace dualpixel {
namespace {

using datasets::testing::bytes_under;
using datasets::testing::small_recipe;
using nlohmann::json;

std::string in_set(const TemporaryFolder& folder) { return " '" + (folder / "set") + "'"; }

Outcome plan(const TemporaryFolder& folder, const json& recipe) {
  folder.write("recipe.json", recipe.dump());
  return run_program("dataset plan '" + (folder / "recipe.json") + "' -o" + in_set(folder));
}

TEST(Dataset, PlansRendersAndVerifies) {
  const TemporaryFolder folder;
  const Outcome planned = plan(folder, small_recipe(3));
  ASSERT_EQ(planned.status, 0) << planned.err;
  EXPECT_EQ(planned.out.substr(0, planned.out.find('\n')),
            "3 samples, 0.02 MB each before compression, 0.00 GB in all");
  const Outcome rendered = run_program("dataset render" + in_set(folder) + " --shard 0/2 --jobs 2");
  EXPECT_EQ(rendered.status, 0) << rendered.err;
  EXPECT_TRUE(rendered.out.starts_with("1 samples: 0 were there, 1 rendered in ")) << rendered.out;
  const json status = json::parse(run_program("dataset status --json" + in_set(folder)).out);
  EXPECT_EQ(status["all"], (json{{"planned", 3}, {"rendered", 1}, {"failed", 0}, {"missing", 2}}));
  EXPECT_EQ(run_program("dataset verify" + in_set(folder)).status, 0);
  EXPECT_EQ(run_program("dataset merge" + in_set(folder)).status, 0);
  std::string page = read_bytes(folder / "set/statistics.html");
  page.erase(page.rfind("<script"));  // whose code speaks of NaN
  EXPECT_NE(page.find("data:image/jpeg"), std::string::npos);
  EXPECT_EQ(page.find("NaN"), std::string::npos);
}

/// Runs with an environment variable set.
Outcome run_with(const std::string& variables, const std::string& arguments) {
  return run_program("--version >/dev/null; " + variables + " '" DUALPIXEL_PROGRAM "' " + arguments);
}

TEST(Dataset, TakesItsShardFromTheBatchSystem) {
  const TemporaryFolder folder;
  plan(folder, small_recipe(3));
  for (const char* variables :
       {"SLURM_ARRAY_TASK_ID=5 SLURM_ARRAY_TASK_MIN=3 SLURM_ARRAY_TASK_COUNT=3",
        "AWS_BATCH_JOB_ARRAY_INDEX=1 AWS_BATCH_JOB_ARRAY_SIZE=3", "JOB_COMPLETION_INDEX=0 JOB_COMPLETION_COUNT=3"}) {
    const Outcome outcome = run_with(variables, "dataset render" + in_set(folder));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.out.starts_with("1 samples: 0 were there, 1 rendered")) << outcome.out;
  }
  const Outcome without = run_with("AWS_BATCH_JOB_ARRAY_INDEX=1", "dataset render" + in_set(folder));
  EXPECT_EQ(without.err,
            "dualpixel: AWS_BATCH_JOB_ARRAY_INDEX is set without AWS_BATCH_JOB_ARRAY_SIZE: give --shard I/N\n");
}

TEST(Dataset, SaysByItsStatusThatSomeFailed) {
  const TemporaryFolder folder;
  json recipe = small_recipe(4);
  folder.write("mine.glb", read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb"));
  recipe["scenes"][0]["file"] = folder / "mine.glb";
  recipe["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {9, 9, 9}}}}};
  ASSERT_EQ(plan(folder, recipe).status, 0);
  folder.write("mine.glb", "glTF");
  const Outcome outcome = run_program("dataset render" + in_set(folder));
  EXPECT_EQ(outcome.status, 5);
  EXPECT_NE(outcome.err.find("failures.jsonl: says why "), std::string::npos) << outcome.err;
}

TEST(Dataset, KilledAndRunAgainItIsTheSame) {
  const TemporaryFolder folder;
  plan(folder, small_recipe(12));
  const std::string start = "dataset render" + in_set(folder) + " & sleep ";
  for (const char* end : {"0.6; kill -9 $!; wait $!", "0.8; kill -USR1 $!; wait $!"}) {
    const Outcome outcome = run_program(start + end);
    EXPECT_TRUE(outcome.status == 128 + 9 || outcome.status == 128 + 10 || outcome.status == 0) << outcome.status;
  }
  EXPECT_EQ(run_program("dataset render" + in_set(folder)).status, 0);
  const TemporaryFolder other;
  plan(other, small_recipe(12));
  run_program("dataset render" + in_set(other));
  EXPECT_EQ(run_program("dataset gc" + in_set(folder)).status, 0);
  EXPECT_TRUE(bytes_under(folder / "set/samples") == bytes_under(other / "set/samples"));
}

// As docs/dataset.md has it, but for the task that dies of SIGKILL once: parallel tries it again.
TEST(Dataset, IsRenderedByGnuParallel) {
  if (std::system("parallel --version 2>/dev/null | grep -q '^GNU parallel'") != 0) {
    GTEST_SKIP() << "GNU parallel is not installed (parallel)";
  }
  const TemporaryFolder folder;
  plan(folder, small_recipe(6));
  folder.write("task.sh", "if [ $1 = 2 ] && [ ! -e '" + (folder / "died") + "' ]; then touch '" + (folder / "died") +
                              "'; kill -9 $$; fi\nexec '" DUALPIXEL_PROGRAM "' dataset render" + in_set(folder) +
                              " --threads 1 --shard $1/4\n");
  folder.write("all.sh", "seq 0 3 | parallel --jobs 2 --retries 3 sh '" + (folder / "task.sh") + "' {}\n");
  const Outcome outcome =
      run_program("--version >/dev/null; HOME='" + folder.path.string() + "' sh '" + (folder / "all.sh") + "'");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "died"));
  const TemporaryFolder other;
  plan(other, small_recipe(6));
  EXPECT_EQ(run_program("dataset render" + in_set(other)).status, 0);
  EXPECT_TRUE(bytes_under(folder / "set/samples") == bytes_under(other / "set/samples"));
}

TEST(Dataset, RefusesInOneLine) {
  const TemporaryFolder folder;
  json recipe = small_recipe();
  recipe["sceens"] = recipe["scenes"];
  expect_one_line_refusal(plan(folder, recipe));
  EXPECT_EQ(folder.names(), std::set<std::string>{"recipe.json"});
  expect_one_line_refusal(run_program("dataset render" + in_set(folder)));
  plan(folder, small_recipe());
  for (const char* shard : {"3/3", "-1/3", "1", "1/0", "a/b", "0/1x"}) {
    expect_one_line_refusal(run_program("dataset render --shard=" + std::string(shard) + in_set(folder)));
  }
  expect_one_line_refusal(run_program("dataset"));
  json longer = small_recipe(7);
  expect_one_line_refusal(plan(folder, longer));
}

}  // namespace
}  // namespace dualpixel
