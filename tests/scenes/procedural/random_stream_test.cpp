#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "scenes/people/body/pose.h"
#include "scenes/people/environment/environment.h"
#include "scenes/people/environment/lighting.h"
#include "scenes/people/shape/material.h"

namespace dualpixel::scenes {
namespace {

TEST(RandomStream, HeldOutDrawsNothingThatTrainingDraws) {
  RandomStream training(5, false), held_out(5, true);
  const auto slot = [](float u) { return static_cast<int>(std::floor(u * 80)) % 5; };
  std::set<int> training_slots, held_out_slots;
  for (int i = 0; i < 10000; ++i) {
    training_slots.insert(slot(training.uniform()));
    held_out_slots.insert(slot(held_out.uniform()));
  }
  EXPECT_EQ(training_slots, (std::set<int>{0, 1, 2, 3}));
  EXPECT_EQ(held_out_slots, (std::set<int>{4}));
  for (RandomStream* rng : {&training, &held_out}) {
    constexpr int kDraws = 20000;
    double sum = 0;
    for (int i = 0; i < kDraws; ++i) sum += rng->normal();
    EXPECT_NEAR(sum / kDraws, 0, 5 / std::sqrt(kDraws));  // five deviations of the mean
  }
  for (const auto& [n, reserved] : {std::pair{kGestures, kReservedGestures},
                                    {kEnvironmentKinds, kReservedEnvironmentKinds},
                                    {kLightingKinds, kReservedLightingKinds}}) {
    for (int i = 0; i < 200; ++i) {
      EXPECT_LT(training.choose(n, reserved), n - reserved);
      EXPECT_GE(held_out.choose(n, reserved), n - reserved);
    }
  }
  for (const MaterialPool& pool : {cloth_pool(), wall_pool()}) {
    for (int i = pool.count - pool.reserved; i < pool.count; ++i) {
      EXPECT_EQ(std::count(pool.kinds, pool.kinds + pool.count - pool.reserved, pool.kinds[i]), 0);
    }
  }
  std::set<Gesture> trained;
  for (int i = 0; i < 500; ++i) {
    trained.insert(random_gesture(training));
    EXPECT_GE(static_cast<int>(random_gesture(held_out)), kGestures - kReservedGestures);
  }
  EXPECT_EQ(trained.size(), static_cast<std::size_t>(kGestures - kReservedGestures));
  EXPECT_LT(static_cast<int>(*trained.rbegin()), kGestures - kReservedGestures);
}

}  // namespace
}  // namespace dualpixel::scenes
