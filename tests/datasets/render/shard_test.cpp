#include "datasets/render/shard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "capture/error.h"

namespace dualpixel::datasets {
namespace {

/// `counts[s]` samples of scene s, in order.
std::vector<SampleLine> lines_of_scenes(const std::vector<int>& counts) {
  std::vector<SampleLine> lines;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    for (int i = 0; i < counts[s]; ++i) {
      SampleLine line;
      line.index = static_cast<int>(lines.size());
      line.scene = {{"file", std::string(1, static_cast<char>('a' + s))}};
      lines.push_back(line);
    }
  }
  return lines;
}

std::string scene_of(const SampleLine& line) { return line.scene.at("file").get<std::string>(); }

/// The scenes that the jobs are given as they ask, "-" for none.
std::string given(LineQueue& queue, const std::vector<int>& asking) {
  std::string scenes;
  for (const int job : asking) {
    const auto line = queue.next(job);
    scenes += line ? scene_of(*line) : "-";
  }
  return scenes;
}

// Scenes whose lines take turns in the plan, whatever the number of shards is.
TEST(Shards, HaveEachLineOnceAndScenesSideBySide) {
  const std::vector<int> counts = {5, 1, 9, 3};
  std::vector<SampleLine> lines = lines_of_scenes(counts);
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.index % 7 < b.index % 7; });
  for (const int shards : {1, 2, 4, 5, 7, 17, 18, 19, 40}) {
    std::vector<int> seen(18, 0);
    int smallest = 18, largest = 0, runs = 0;
    std::string last;
    for (int i = 0; i < shards; ++i) {
      const std::vector<SampleLine> part = lines_of(lines, {i, shards});
      smallest = std::min(smallest, static_cast<int>(part.size()));
      largest = std::max(largest, static_cast<int>(part.size()));
      for (const SampleLine& line : part) {
        ++seen[static_cast<std::size_t>(line.index)];
        runs += std::exchange(last, scene_of(line)) != scene_of(line) ? 1 : 0;
      }
    }
    EXPECT_EQ(seen, std::vector<int>(18, 1)) << shards;
    EXPECT_LE(largest - smallest, 1) << shards;
    EXPECT_EQ(runs, 4) << shards;
  }
}

TEST(Shards, KeepSamplesOfOneLightTogether) {
  std::vector<SampleLine> lines = lines_of_scenes({4});
  const char* nits[] = {"dim", "bright", "dim", "bright"};
  for (std::size_t i = 0; i < 4; ++i) lines[i].set = {{"environment.path", nits[i]}, {"exposure.iso", i}};
  std::string order;
  for (const SampleLine& line : lines_of(lines, {0, 1})) order += std::to_string(line.index);
  EXPECT_EQ(order, "1302");
}

/// Of a task of a Slurm array; -1: not set.
std::string slurm_shard(int id, int count, int first, int last, int step) {
  const std::pair<const char*, int> variables[] = {{"SLURM_ARRAY_TASK_ID", id},
                                                   {"SLURM_ARRAY_TASK_COUNT", count},
                                                   {"SLURM_ARRAY_TASK_MIN", first},
                                                   {"SLURM_ARRAY_TASK_MAX", last},
                                                   {"SLURM_ARRAY_TASK_STEP", step}};
  for (const auto& [name, value] : variables) {
    if (value >= 0) setenv(name, std::to_string(value).c_str(), 1);
  }
  std::string result;
  try {
    const Shard shard = shard_of_environment();
    result = std::to_string(shard.index) + "/" + std::to_string(shard.count);
  } catch (const InputError& error) {
    result = error.what();
  }
  for (const auto& [name, value] : variables) unsetenv(name);
  return result;
}

TEST(Shards, AreTheTasksOfASlurmArray) {
  EXPECT_EQ(slurm_shard(7, 20, 0, 19, 1), "7/20");  // --array=0-19
  EXPECT_EQ(slurm_shard(5, 3, 3, 5, 1), "2/3");     // 3-5
  EXPECT_EQ(slurm_shard(20, 4, 0, 30, 10), "2/4");  // 0-30:10, and 0-39:10, whose last task is 30, too
  EXPECT_EQ(slurm_shard(11, 3, 1, 11, 5), "2/3");   // 1-11:5
  EXPECT_EQ(slurm_shard(4, 1, 4, 4, 1), "0/1");     // 4
  EXPECT_EQ(slurm_shard(1, 2, 0, -1, -1), "1/2");
  for (const int id : {1, 3, 7}) {  // 1,3,7
    EXPECT_EQ(slurm_shard(id, 3, 1, 7, 1),
              "SLURM_ARRAY_TASK_ID: " + std::to_string(id) +
                  ": is in an array of 3 tasks from 1 to 7 that are not evenly spaced, which leaves open what part it "
                  "is: give --shard I/N, or an array such as 0-2");
  }
  EXPECT_NE(slurm_shard(9, 3, 0, 2, 1).find("not evenly spaced"), std::string::npos);
  EXPECT_EQ(slurm_shard(1, -1, 0, 2, 1), "SLURM_ARRAY_TASK_ID is set without SLURM_ARRAY_TASK_COUNT: give --shard I/N");
}

TEST(LineQueue, AJobStaysWithItsSceneAndThenTakesOneThatNobodyHas) {
  LineQueue queue(lines_of_scenes({2, 4, 3}), 2);
  // the longest first: job 0 has b, job 1 has c and then a
  EXPECT_EQ(given(queue, {0, 1, 1, 0, 1, 1, 1}), "bccbcaa");
}

TEST(LineQueue, AJobWithoutASceneHelpsWhereMostIsLeft) {
  LineQueue queue(lines_of_scenes({7, 6, 1}), 3);
  EXPECT_EQ(given(queue, {0, 1, 2}), "abc");
  EXPECT_EQ(given(queue, {2, 2, 2}), "aaa");  // six of a are left, five of b
  EXPECT_EQ(given(queue, {0, 0, 0, 0, 0, 1, 2, 1, 0, 1, 2}), "aaabbbbb---");
}

TEST(LineQueue, GivesEachLineOnce) {
  LineQueue queue(lines_of_scenes({5, 1, 9, 3}), 4);
  std::vector<int> seen(18, 0);
  for (int job = 0; const auto line = queue.next(job % 4); job += 3) ++seen[static_cast<std::size_t>(line->index)];
  EXPECT_EQ(seen, std::vector<int>(18, 1));
  LineQueue none({}, 2);
  EXPECT_FALSE(none.next(1));
}

}  // namespace
}  // namespace dualpixel::datasets
