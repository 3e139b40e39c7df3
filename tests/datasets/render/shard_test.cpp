#include "datasets/render/shard.h"

#include <gtest/gtest.h>

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
