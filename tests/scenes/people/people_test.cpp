#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "scenes/people/people.h"

namespace dualpixel::scenes {
namespace {

/// Six samples, some of them composites, made once for all tests here.
/// The first picture is of a group.
const std::vector<PeopleSample>& few_samples() {
  static const std::vector<PeopleSample> samples = make_people_shard({.count = 6, .seed = 17, .composites = 2}, 0, 6);
  return samples;
}

/// Everything of a sample as one string.
std::string all_of(const PeopleSample& s) {
  std::string bytes(s.picture.begin(), s.picture.end());
  bytes.append(s.mask.begin(), s.mask.end());
  for (const auto& k : s.keypoints) bytes += std::to_string(k.x) + std::to_string(k.y) + std::to_string(k.z);
  return bytes + std::to_string(s.face.x) + std::to_string(s.seed) + std::to_string(s.picture_index);
}

TEST(SlowPeople, SamplesDoNotDependOnHowManyThereAre) {
  const auto four = make_people_shard({.count = 4, .seed = 17, .composites = 2}, 0, 4);
  ASSERT_EQ(four.size(), 4u);
  for (std::size_t i = 0; i < four.size(); ++i) EXPECT_EQ(all_of(four[i]), all_of(few_samples()[i])) << i;
  EXPECT_FALSE(four[0].composite);
  EXPECT_TRUE(four[3].composite);  // whose background is shared by a shard's
}

TEST(SlowPeople, SamplesOfOnePictureShareItAndNotTheirPeople) {
  const auto& samples = few_samples();
  int pairs = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const PeopleSample& s = samples[i];
    EXPECT_EQ(s.picture.size(), 256u * 256 * 3);
    EXPECT_GT(std::count(s.mask.begin(), s.mask.end(), 255), 100);
    for (std::size_t k = i + 1; k < samples.size(); ++k) {
      if (samples[k].picture_index != s.picture_index) continue;
      ++pairs;
      EXPECT_EQ(samples[k].picture, s.picture);
      for (std::size_t p = 0; p < s.mask.size(); ++p) EXPECT_LE(s.mask[p] + samples[k].mask[p], 256);
    }
  }
  EXPECT_GT(pairs, 0);
  EXPECT_TRUE(std::any_of(samples.begin(), samples.end(), [](const auto& s) { return s.composite; }));
  EXPECT_FALSE(samples[0].composite);
}

TEST(SlowPeople, OnlyTrainingSetsAreDomainRandomized) {
  const auto randomized_of = [](bool held_out) {
    const auto samples = make_people_shard({.count = 16, .seed = 3, .held_out = held_out, .composites = 1}, 0, 16);
    std::map<int, std::set<bool>> randomized_by_figure;  // of each figure, its rendering and its composites
    for (const PeopleSample& s : samples) {
      const bool randomized = std::count(s.tags.begin(), s.tags.end(), "domain_randomized") == 1;
      randomized_by_figure[s.picture_index / 2].insert(randomized);
    }
    std::set<bool> seen;
    for (const auto& [picture, kinds] : randomized_by_figure) {
      EXPECT_EQ(kinds.size(), 1u) << picture;
      seen.insert(kinds.begin(), kinds.end());
    }
    return seen;
  };
  EXPECT_EQ(randomized_of(false), (std::set<bool>{false, true}));
  EXPECT_EQ(randomized_of(true), std::set<bool>{false});
}

TEST(SlowPeople, SameSeedSameBytesForOneThreadAndTwo) {
  const PeopleOptions options{.count = 6, .seed = 17, .composites = 2};
  std::vector<PeopleSample> alone;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    alone = make_people_shard(options, 0, 6);
  }
  ASSERT_EQ(alone.size(), few_samples().size());
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(all_of(alone[i]), all_of(few_samples()[i])) << i;
  const auto other = make_people_shard({.count = 6, .seed = 12, .composites = 2}, 0, 1);
  EXPECT_NE(all_of(other[0]), all_of(alone[0]));
}

}  // namespace
}  // namespace dualpixel::scenes
