// `dualpixel dataset` as a user gives it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "datasets/plan/plan.h"
#include "datasets/render/sample_folder.h"
#include "datasets/render/shard.h"
#include "tests/datasets/small_recipe.h"
#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

using datasets::testing::bytes_under;
using datasets::testing::small_recipe;
using nlohmann::json;

std::string in_set(const TemporaryFolder& folder) { return " '" + (folder / "set") + "'"; }

Outcome plan(const TemporaryFolder& folder, const json& recipe) {
  folder.write("recipe.json", recipe.dump());
  return run_command("dataset plan '" + (folder / "recipe.json") + "' -o" + in_set(folder));
}

TEST(SlowDataset, PlansRendersAndVerifies) {
  const TemporaryFolder folder;
  const Outcome planned = plan(folder, small_recipe(3));
  ASSERT_EQ(planned.status, 0) << planned.err;
  EXPECT_EQ(planned.out.substr(0, planned.out.find('\n')),
            "3 samples, 0.02 MB each before compression, 0.00 GB in all");
  const Outcome rendered = run_command("dataset render" + in_set(folder) + " --shard 0/2 --jobs 2");
  EXPECT_EQ(rendered.status, 0) << rendered.err;
  EXPECT_TRUE(rendered.out.starts_with("1 samples: 0 were there, 1 rendered in ")) << rendered.out;
  const json status = json::parse(run_command("dataset status --json" + in_set(folder)).out);
  EXPECT_EQ(status["all"], (json{{"planned", 3}, {"rendered", 1}, {"failed", 0}, {"missing", 2}}));
  EXPECT_EQ(run_command("dataset verify" + in_set(folder)).status, 0);
  EXPECT_EQ(run_command("dataset merge" + in_set(folder)).status, 0);
  std::string page = read_bytes(folder / "set/statistics.html");
  page.erase(page.rfind("<script"));  // whose code speaks of NaN
  EXPECT_NE(page.find("data:image/jpeg"), std::string::npos);
  EXPECT_EQ(page.find("NaN"), std::string::npos);
}

/// Runs with an environment variable set.
Outcome run_with(const std::string& variables, const std::string& arguments) {
  return run_program("--version >/dev/null; " + variables + " '" DUALPIXEL_PROGRAM "' " + arguments);
}

TEST(SlowDataset, TakesItsShardFromTheBatchSystem) {
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

TEST(SlowDataset, SaysByItsStatusThatSomeFailed) {
  const TemporaryFolder folder;
  json recipe = small_recipe(4);
  folder.write("mine.glb", read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb"));
  recipe["scenes"][0]["file"] = folder / "mine.glb";
  recipe["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {9, 9, 9}}}}};
  ASSERT_EQ(plan(folder, recipe).status, 0);
  folder.write("mine.glb", "glTF");
  const Outcome outcome = run_command("dataset render" + in_set(folder));
  EXPECT_EQ(outcome.status, 5);
  EXPECT_NE(outcome.err.find("failures.jsonl: says why "), std::string::npos) << outcome.err;
}

/// Samples that take some tenths of a second each, so that a render can be cut in the middle.
json slow_recipe(int count) {
  json recipe = small_recipe(count);
  recipe["set"]["render.samples_per_pixel"] = 256;
  return recipe;
}

/// How many samples are there.
std::size_t samples_in(const TemporaryFolder& folder) {
  return json::parse(run_command("dataset status --json" + in_set(folder)).out)["all"]["rendered"];
}

/// The names of the samples that are missing, in the order in which one job renders them.
std::vector<std::string> missing_in(const TemporaryFolder& folder, const datasets::Shard& shard = {}) {
  std::vector<datasets::SampleLine> lines = datasets::lines_of(datasets::read_plan(folder / "set"), shard);
  std::erase_if(lines, [&](const auto& line) { return datasets::is_there(folder / "set", line); });
  datasets::LineQueue queue(std::move(lines), 1);
  std::vector<std::string> names;
  while (const auto line = queue.next(0)) names.push_back(line->name);
  return names;
}

/// A shell script that renders, sends the signal when the sample NAME is there, and ends with the status of the render.
std::string cut_after(const std::string& name, const std::string& signal, const TemporaryFolder& folder,
                      const std::string& options = "") {
  return "'" DUALPIXEL_PROGRAM "' dataset render" + in_set(folder) + options + " & render=$!\nwaits=0\nwhile [ ! -e '" +
         (folder / ("set/samples/" + name)) +
         "' ] && [ $waits -lt 6000 ]; do sleep 0.01; waits=$((waits+1)); done\nkill -" + signal +
         " $render\nwait $render\n";
}

Outcome run_script(const std::string& text, const TemporaryFolder& folder) {
  folder.write("script.sh", text);
  return run_program("--version >/dev/null; sh '" + (folder / "script.sh") + "'");
}

void expect_bytes_of_one_run(const TemporaryFolder& folder, const json& recipe) {
  const TemporaryFolder other;
  plan(other, recipe);
  EXPECT_EQ(run_command("dataset render" + in_set(other)).status, 0);
  EXPECT_TRUE(bytes_under(folder / "set/samples") == bytes_under(other / "set/samples"));
}

TEST(SlowDataset, KilledAndRunAgainItIsTheSame) {
  const TemporaryFolder folder;
  constexpr int kCount = 12;
  plan(folder, slow_recipe(kCount));
  EXPECT_EQ(run_script(cut_after(missing_in(folder)[1], "KILL", folder), folder).status, 128 + 9);
  const std::size_t killed = samples_in(folder);
  EXPECT_GE(killed, 2U);
  ASSERT_LT(killed, kCount);
  EXPECT_EQ(run_script(cut_after(missing_in(folder)[0], "USR1", folder), folder).status, 128 + 10);
  const std::size_t stopped = samples_in(folder);
  EXPECT_GT(stopped, killed);
  EXPECT_LT(stopped, kCount);
  const Outcome rest = run_command("dataset render" + in_set(folder));
  EXPECT_TRUE(rest.out.starts_with("12 samples: " + std::to_string(stopped) + " were there, " +
                                   std::to_string(kCount - stopped) + " rendered"))
      << rest.out;
  EXPECT_EQ(run_command("dataset gc" + in_set(folder)).status, 0);
  expect_bytes_of_one_run(folder, slow_recipe(kCount));
}

// As docs/dataset.md has it, but for the task that dies of SIGKILL once, in the middle: parallel tries it again.
TEST(SlowDataset, IsRenderedByGnuParallel) {
  if (std::system("parallel --version 2>/dev/null | grep -q '^GNU parallel'") != 0) {
    GTEST_SKIP() << "GNU parallel is not installed (parallel)";
  }
  const TemporaryFolder folder;
  plan(folder, slow_recipe(12));
  const std::vector<std::string> part = missing_in(folder, {2, 4});
  ASSERT_EQ(part.size(), 3U);
  const std::string died = "'" + (folder / "died") + "'";
  folder.write("task.sh", "if [ $1 = 2 ] && [ ! -e " + died + " ]; then\n" +
                              cut_after(part[0], "KILL", folder, " --threads 1 --shard 2/4") + "echo $? > " + died +
                              "; kill -9 $$; fi\nexec '" DUALPIXEL_PROGRAM "' dataset render" + in_set(folder) +
                              " --threads 1 --shard $1/4 >> '" + (folder / "tasks.txt") + "'\n");
  const Outcome outcome = run_script("HOME='" + folder.path.string() + "' seq 0 3 | HOME='" + folder.path.string() +
                                         "' parallel --jobs 2 --retries 3 sh '" + (folder / "task.sh") + "' {}\n",
                                     folder);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_bytes(folder / "died"), "137\n");
  const std::string tasks = read_bytes(folder / "tasks.txt");
  EXPECT_TRUE(tasks.find("3 samples: 1 were there") != std::string::npos ||
              tasks.find("3 samples: 2 were there") != std::string::npos)
      << tasks;
  EXPECT_EQ(run_command("dataset gc" + in_set(folder)).status, 0);
  expect_bytes_of_one_run(folder, slow_recipe(12));
}

TEST(Dataset, RefusesInOneLine) {
  const TemporaryFolder folder;
  json recipe = small_recipe();
  recipe["sceens"] = recipe["scenes"];
  expect_one_line_refusal(plan(folder, recipe));
  EXPECT_EQ(folder.names(), std::set<std::string>{"recipe.json"});
  expect_one_line_refusal(run_command("dataset render" + in_set(folder)));
  plan(folder, small_recipe());
  for (const char* shard : {"3/3", "-1/3", "1", "1/0", "a/b", "0/1x"}) {
    expect_one_line_refusal(run_command("dataset render --shard=" + std::string(shard) + in_set(folder)));
  }
  expect_one_line_refusal(run_command("dataset"));
  json other = small_recipe(7);
  other["seed"] = 6;
  expect_one_line_refusal(plan(folder, other));
  const Outcome list =
      run_command("dataset plan --count 3 -o" + in_set(folder) + " '" + folder.write("list.json", "[1]") + "'");
  expect_one_line_refusal(list);
  EXPECT_EQ(list.err, "dualpixel: " + (folder / "list.json") + ": must be an object\n");
}

TEST(SlowDataset, GrowsByALargerCount) {
  const TemporaryFolder folder;
  ASSERT_EQ(plan(folder, small_recipe(2)).status, 0);
  EXPECT_EQ(run_command("dataset render" + in_set(folder)).status, 0);
  const std::string first = read_bytes(folder / "set/plan.jsonl");
  ASSERT_EQ(plan(folder, small_recipe(4)).status, 0);
  EXPECT_TRUE(read_bytes(folder / "set/plan.jsonl").starts_with(first));
  const Outcome rest = run_command("dataset render" + in_set(folder));
  EXPECT_TRUE(rest.out.starts_with("4 samples: 2 were there, 2 rendered")) << rest.out;
  expect_bytes_of_one_run(folder, small_recipe(4));
}

// As docs/dataset.md says: gc removes drawn scenes, and what a sample says of its scene brings it back.
TEST(SlowDataset, SamplesSayHowTheyAreMadeAgain) {
  const TemporaryFolder folder;
  json recipe = small_recipe(1);
  recipe["scenes"] = {{{"kind", "chart"}, {"seeds", {3, 3}}, {"set", {{"width_px", 128}, {"lens.f_number", 2.4}}}}};
  recipe["keep"] = {"left", "left_rgb"};
  ASSERT_EQ(plan(folder, recipe).status, 0);
  ASSERT_EQ(run_command("dataset render" + in_set(folder)).status, 0);
  std::filesystem::rename(folder / "set", folder / "moved");  // and the data set may lie elsewhere
  ASSERT_EQ(run_command("dataset gc '" + (folder / "moved") + "'").status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "moved/scenes"));
  const std::string sample = folder / "moved/samples/000000";
  const json provenance = json::parse(read_bytes(sample + "/sample.json"))["provenance"];
  const std::string command = provenance["scene_command"];
  ASSERT_TRUE(command.starts_with("dualpixel scene chart --seed 3 --set ")) << command;
  const Outcome drawn = run_program("--version >/dev/null; cd '" + (folder / "moved") + "' && '" DUALPIXEL_PROGRAM "'" +
                                    command.substr(std::string("dualpixel").size()));
  ASSERT_EQ(drawn.status, 0) << drawn.err;
  write_bytes(sample + "/scene.json", provenance["scene"].dump());
  const Outcome rendered = run_command("simulate '" + sample + "/scene.json' -o '" + (folder / "capture") + "'");
  ASSERT_EQ(rendered.status, 0) << rendered.err;
  const Image kept = read_npy(sample + "/left_rgb.npy");
  const std::vector<Image> views = read_exr(folder / "capture/truth/views.exr", {"left.R", "left.G", "left.B"});
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kept.height; ++y) {
      for (int x = 0; x < kept.width; ++x) {
        // the file of a capture holds half floats, of 11 bits
        ASSERT_NEAR(views[static_cast<std::size_t>(c)].at(x, y), kept.at(x, y, c), 1e-3 * kept.at(x, y, c) + 1e-7);
      }
    }
  }
}

}  // namespace
}  // namespace dualpixel
