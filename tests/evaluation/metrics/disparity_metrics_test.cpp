#include "evaluation/metrics/disparity_metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace dualpixel::evaluation {
namespace {

using Values = std::vector<float>;

Values random_values(std::size_t count, unsigned seed) {
  std::mt19937 generator(seed);
  Values values(count);
  for (float& value : values) value = static_cast<float>(generator()) / 4294967296.0f * 4 - 2;
  return values;
}

TEST(AffineFit, RecoversAnAffineMap) {
  const Values estimate = random_values(1000, 1);
  Values truth(estimate.size());
  std::transform(estimate.begin(), estimate.end(), truth.begin(), [](float e) { return 2 * e - 0.3f; });
  const AffineFit fit = fit_affine(estimate, truth);
  // Rounding of the truth to float is 1e-7; the ridge shifts the fit by 1e-5 / 1000.
  EXPECT_NEAR(fit.scale, 2, 1e-6);
  EXPECT_NEAR(fit.offset, -0.3, 1e-6);
  EXPECT_NEAR(rmse(estimate, truth, fit), 0, 1e-6);
  EXPECT_NEAR(aiwe1(estimate, truth), 0, 1e-6);
}

TEST(AffineFit, AgreesWithRegressionByHand) {
  // Means 1.5 and 1.25, Sxx = 5, Sxy = 4.5, Syy = 4.75: slope 0.9, squares left over 4.75 - 0.9 * 4.5 = 0.7.
  const Values estimate = {0, 1, 2, 3}, truth = {0, 1, 1, 3};
  const AffineFit fit = fit_affine(estimate, truth);
  EXPECT_NEAR(fit.scale, 0.9, 1e-5);
  EXPECT_NEAR(fit.offset, 1.25 - 0.9 * 1.5, 1e-5);
  EXPECT_NEAR(rmse(estimate, truth, fit), std::sqrt(0.7 / 4), 1e-9);
}

TEST(AffineFit, ConstantEstimateLeavesTheSpreadOfTheTruth) {
  const Values estimate(4, 0.7f), truth = {1, 2, 3, 4};
  const AffineFit fit = fit_affine(estimate, truth);
  EXPECT_NEAR(fit.scale * 0.7 + fit.offset, 2.5, 1e-4);
  EXPECT_NEAR(rmse(estimate, truth, fit), std::sqrt(1.25), 1e-6);
}

TEST(Error, BiasRmseAndBadPixelsByHand) {
  const Values estimate = {0.05f, 0.2f, -0.3f, 1}, truth = {0, 0, 0, 0};
  EXPECT_NEAR(bias(estimate, truth), 0.95 / 4, 1e-7);
  EXPECT_NEAR(rmse(estimate, truth), std::sqrt((0.0025 + 0.04 + 0.09 + 1) / 4), 1e-7);
  EXPECT_EQ(bad_pixel_rate(estimate, truth, 0.1), 0.75);
  EXPECT_EQ(bad_pixel_rate(estimate, truth, 0.25), 0.5);
  EXPECT_EQ(bad_pixel_rate(estimate, truth, 0.5), 0.25);
}

TEST(Aiwe1, AgreesWithFiveRoundsElsewhere) {
  // The five rounds without the ridge, in Python, by centered sums.
  const Values estimate = {0, 1, 2, 3, 4, 5}, truth = {0.1f, 1.2f, 1.8f, 3.3f, 3.9f, 9};
  EXPECT_NEAR(aiwe1(estimate, truth), 0.7610214, 1e-5);
}

TEST(Ranks, TiesShareTheirAverage) {
  EXPECT_EQ(average_ranks(Values{-1, 0, -0.0f, 3, -5}), (std::vector<double>{2, 3.5, 3.5, 5, 1}));
  EXPECT_EQ(average_ranks(Values{7, 7, 7}), (std::vector<double>{2, 2, 2}));
  EXPECT_TRUE(average_ranks(Values{}).empty());
}

TEST(Ranks, AgreeWithComparisonSort) {
  Values values = random_values(20000, 2);
  for (float& value : values) value = std::round(value * 500) / 500;  // about 2000 values: ties of ten
  values[0] = 1e30f;
  values[1] = -1e-30f;
  Values sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::vector<double> ranks = average_ranks(values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [low, high] = std::equal_range(sorted.begin(), sorted.end(), values[i]);
    ASSERT_EQ(ranks[i], (low - sorted.begin() + high - sorted.begin() + 1) / 2.0) << values[i];
  }
}

TEST(Spearman, WithTiesByHand) {
  // Ranks 1, 2.5, 2.5, 4 and 1, 4, 2.5, 2.5: 2.25 / 4.5.
  EXPECT_NEAR(*spearman(Values{1, 2, 2, 4}, Values{10, 30, 20, 20}), 0.5, 1e-12);
}

TEST(Spearman, SeesOrderAlone) {
  const Values a = random_values(500, 3);
  Values grows(a.size()), falls(a.size());
  std::transform(a.begin(), a.end(), grows.begin(), [](float v) { return std::exp(3 * v); });
  std::transform(a.begin(), a.end(), falls.begin(), [](float v) { return -v * v * v; });
  EXPECT_NEAR(*spearman(a, grows), 1, 1e-12);
  EXPECT_NEAR(*spearman(a, falls), -1, 1e-12);
}

TEST(Spearman, IsUndefinedForConstants) {
  EXPECT_FALSE(spearman(Values{1, 1, 1}, Values{1, 2, 3}));
  EXPECT_FALSE(spearman(Values{1, 2, 3}, Values{0, -0.0f, 0}));
}

TEST(Sparsification, PerfectConstantAndReversedConfidenceByHand) {
  const Values error = {1, 2, 3, 4};
  const Sparsification perfect = sparsification(error, Values{4, 3, 2, 1});
  EXPECT_EQ(*perfect.ause, 0);
  // The oracle's means of the best 4, 3, 2, 1: 2.5, 2, 1.5, 1. A constant confidence stays at 2.5.
  EXPECT_NEAR(*sparsification(error, Values(4, 0.5f)).ause, (0 + 0.5 + 1 + 1.5) / 4 / 2.5, 1e-12);
  // The reversed one: 2.5, 3, 3.5, 4.
  EXPECT_NEAR(*sparsification(error, error).ause, (0 + 1 + 2 + 3) / 4.0 / 2.5, 1e-12);
}

TEST(Sparsification, ConstantConfidenceOnUniformErrorsGivesOneHalf) {
  // Errors uniform on 0..1: the oracle's mean of the rest is (1 - f) / 2, so its area is half of the mean error.
  constexpr int kCount = 10000;
  Values error(kCount);
  for (int i = 0; i < kCount; ++i) error[i] = (i + 0.5f) / kCount;
  const Sparsification curves = sparsification(error, Values(kCount, 1));
  EXPECT_NEAR(*curves.ause, 0.5, 1.0 / kCount);
  ASSERT_EQ(curves.removed.size(), 20u);
  EXPECT_EQ(curves.removed[5], 0.25);
  EXPECT_NEAR(curves.error[5], 0.5, 1e-6);
  EXPECT_NEAR(curves.oracle[5], 0.375, 1e-6);
}

TEST(Sparsification, HasNoAreaWithoutErrors) {
  EXPECT_FALSE(sparsification(Values{0, 0}, Values{1, 0}).ause);
  EXPECT_FALSE(sparsification(Values{}, Values{}).ause);
}

TEST(DepthEdges, ReachAsManyPixelsAsSaidOnBothSides) {
  Image disparity(40, 10);
  for (int y = 0; y < 10; ++y) std::fill_n(disparity.row(y) + 20, 20, 0.2f);  // the border lies between 19 and 20
  const Mask edges = depth_edges(disparity, 0.1f, 8);
  for (int x = 0; x < 40; ++x) EXPECT_EQ(edges.at(x, 5), x >= 12 && x <= 27) << x;
  const Mask none = depth_edges(disparity, 0.3f, 8);
  EXPECT_EQ(std::count(none.data.begin(), none.data.end(), 1), 0);
}

TEST(DepthEdges, SurroundASinglePixelWithASquare) {
  Image disparity(21, 21);
  disparity.at(10, 10) = 1;  // its four borders mark it and its four neighbors, each 1 away
  const Mask edges = depth_edges(disparity, 0.1f, 3);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 21; ++x) {
      const int dx = std::abs(x - 10), dy = std::abs(y - 10);
      EXPECT_EQ(edges.at(x, y), std::max(dx, dy) <= 3 && std::min(dx, dy) <= 2) << x << " " << y;
    }
  }
}

TEST(DepthEdges, MayReachBeyondTheImage) {
  Image disparity(3, 2);
  disparity.at(0, 0) = 1;
  const Mask edges = depth_edges(disparity, 0.1f, 8);
  EXPECT_EQ(std::count(edges.data.begin(), edges.data.end(), 1), 6);
}

}  // namespace
}  // namespace dualpixel::evaluation
