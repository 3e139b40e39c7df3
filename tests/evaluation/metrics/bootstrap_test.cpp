#include "evaluation/metrics/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dualpixel::evaluation {
namespace {

TEST(Bootstrap, OfFewValuesIsTheirDistribution) {
  const MeanInterval same = bootstrap_mean({3, 3, 3});
  EXPECT_EQ(same.mean, 3);
  EXPECT_EQ(same.low, 3);
  EXPECT_EQ(same.high, 3);
  // Of two values a quarter of the samples hold the one alone, and a quarter the other
  const MeanInterval two = bootstrap_mean({0, 1});
  EXPECT_EQ(two.mean, 0.5);
  EXPECT_EQ(two.low, 0);
  EXPECT_EQ(two.high, 1);
}

// The mean of n values is about normal, of deviation sigma / sqrt(n). 2.5 % quantiles of 10 000 samples have a standard
// error of sqrt(.025 .975 / 10000) / .058 = .027 of that; .15 is beyond five of them.
TEST(Bootstrap, OfManyValuesIsTheNormalInterval) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(10, 2);
  std::vector<double> values(400);
  double sum = 0, squares = 0;
  for (double& value : values) {
    value = normal(random);
    sum += value, squares += value * value;
  }
  const double mean = sum / 400, error = std::sqrt((squares / 400 - mean * mean) / 400);
  const MeanInterval interval = bootstrap_mean(values);
  EXPECT_NEAR(interval.mean, mean, 1e-12);
  EXPECT_NEAR(interval.low, mean - 1.96 * error, 0.15 * error);
  EXPECT_NEAR(interval.high, mean + 1.96 * error, 0.15 * error);
}

}  // namespace
}  // namespace dualpixel::evaluation
