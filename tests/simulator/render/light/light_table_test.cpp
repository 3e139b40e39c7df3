#include "simulator/render/light/light_table.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "simulator/sampling/hash.h"

namespace dualpixel::simulator::testing {
namespace {

// 18 bits hold the largest value to half of 2^-17 of itself, the others to the same step.
TEST(LightTable, PacksToFourMillionths) {
  for (const glm::vec3 rgb : {glm::vec3(1, 0.5f, 0.001f), glm::vec3(0.9999999f, 1e-7f, 0.3f), glm::vec3(120000, 3, 800),
                              glm::vec3(3e-12f, 2e-12f, 1e-12f)}) {
    const glm::vec3 back = LightTable::unpack(LightTable::pack(rgb));
    const float largest = std::max({rgb.x, rgb.y, rgb.z});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[c], rgb[c], 4e-6f * largest) << c;
  }
  EXPECT_EQ(LightTable::unpack(LightTable::pack(glm::vec3(0))), glm::vec3(0));
  EXPECT_NE(LightTable::pack(glm::vec3(0)), 0u) << "0 means that nothing is there yet";
}

TEST(LightTable, FindsWhatWasAdded) {
  LightTable table(1 << 20);
  EXPECT_FALSE(table.find(3, 5));
  const SurfaceLight added = table.add(3, 5, {glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)});
  const auto found = table.find(3, 5);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->soft, added.soft);
  EXPECT_EQ(found->hard, added.hard);
  EXPECT_FALSE(table.find(3, 7));
}

// A full table turns points away, gives back what was computed, and keeps what it holds.
TEST(LightTable, IsBoundedAndLosesNothing) {
  LightTable table(4096);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const glm::vec3 light(static_cast<float>(i + 1));
    EXPECT_EQ(table.add(0, hash(i) | 1, {light, light}).soft, LightTable::unpack(LightTable::pack(light)));
  }
  EXPECT_LE(table.points(), 128u);
  EXPECT_EQ(table.points() + table.turned_away(), 1000u);
  std::uint64_t held = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const auto found = table.find(0, hash(i) | 1);
    if (!found) continue;
    ++held;
    EXPECT_NEAR(found->soft.x, static_cast<float>(i + 1), 4e-6f * static_cast<float>(i + 1));
  }
  EXPECT_EQ(held, table.points());
}

// Threads that add the same points at once never show a point half written.
TEST(LightTable, ThreadsAgree) {
  LightTable table(1 << 22);
  std::atomic<int> wrong = 0;
  tbb::parallel_for(0, 100000, [&](int i) {
    const std::uint64_t key = hash(i % 5000) | 1;
    const glm::vec3 light(static_cast<float>(i % 5000 + 1), 1, 2), hard(7, static_cast<float>(i % 5000), 0);
    const SurfaceLight expected{LightTable::unpack(LightTable::pack(light)),
                                LightTable::unpack(LightTable::pack(hard))};
    const auto found = table.find(key >> 20, key);
    const SurfaceLight got = found ? *found : table.add(key >> 20, key, {light, hard});
    if (got.soft != expected.soft || got.hard != expected.hard) ++wrong;
  });
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
