#include "simulator/render/shading/light_groups.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace dualpixel::simulator {
namespace {

/// `count` lamps, 5 m apart, of twenty pieces each in a ball of 10 cm; the lamp is index / 20. One is a hundred times
/// as strong.
std::vector<LightSource> lamps(int count) {
  std::vector<LightSource> lights;
  for (int piece = 0; piece < 20; ++piece) {
    for (int lamp = 0; lamp < count; ++lamp) {
      const float angle = 0.9f * static_cast<float>(piece);
      const glm::vec3 at(5.0f * static_cast<float>(lamp) + 0.1f * std::cos(angle), 0, 0.1f * std::sin(angle));
      lights.push_back(
          {static_cast<std::size_t>(20 * lamp + piece), at - 0.01f, at + 0.01f, lamp == 3 ? 200.0f : 2.0f, 0.5f});
    }
  }
  return lights;
}

TEST(LightGroups, HoldEachLightOnce) {
  std::vector<LightSource> lights = lamps(13);
  const std::vector<LightGroup> groups = group_lights(lights, 32);
  EXPECT_EQ(groups.size(), 32u);
  std::set<std::size_t> seen;
  float candela = 0, lux = 0;
  for (const LightGroup& group : groups) {
    candela += group.candela, lux += group.average_lux;
    for (std::size_t i = group.first; i < group.end; ++i) {
      EXPECT_TRUE(seen.insert(lights[i].index).second);
      for (const glm::vec3 corner : {lights[i].low, lights[i].high}) {
        EXPECT_LE(glm::length(corner - group.center), group.radius_m * (1 + 1e-5f));
      }
    }
  }
  EXPECT_EQ(seen.size(), 260u);
  EXPECT_FLOAT_EQ(candela, 12 * 40 + 4000);
  EXPECT_FLOAT_EQ(lux, 130);
}

TEST(LightGroups, AreOneLampEachWhereThereAreEnough) {
  std::vector<LightSource> lights = lamps(16);
  const std::vector<LightGroup> groups = group_lights(lights, 16);
  EXPECT_EQ(groups.size(), 16u);
  for (const LightGroup& group : groups) {
    std::set<std::size_t> of_lamps;
    for (std::size_t i = group.first; i < group.end; ++i) of_lamps.insert(lights[i].index / 20);
    EXPECT_EQ(of_lamps.size(), 1u);
    EXPECT_LT(group.radius_m, 0.2f);
  }
}

// Halfway between two neighboring numbers is one of them.
TEST(LightGroups, EndWhereNumbersDo) {
  const float next = std::nextafter(1.0f, 2.0f);
  std::vector<LightSource> lights = {{0, glm::vec3(1), glm::vec3(1), 3, 1},
                                     {1, glm::vec3(next), glm::vec3(next), 3, 1}};
  const std::vector<LightGroup> groups = group_lights(lights, 32);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].end, 2u);
}

TEST(LightGroups, StayTogetherInOnePlace) {
  std::vector<LightSource> lights(5, LightSource{0, glm::vec3(1), glm::vec3(1), 3, 1});
  ASSERT_EQ(group_lights(lights, 32).size(), 1u);
  EXPECT_EQ(group_lights(lights, 32)[0].candela, 15);
  // and others are split nevertheless
  lights.push_back({1, glm::vec3(2), glm::vec3(2), 1e-3f, 1});
  lights.push_back({2, glm::vec3(2.1f), glm::vec3(2.1f), 1e-3f, 1});
  EXPECT_EQ(group_lights(lights, 32).size(), 3u);
  lights.clear();
  EXPECT_TRUE(group_lights(lights, 32).empty());
}

}  // namespace
}  // namespace dualpixel::simulator
