#include "evaluation/experiments/edge_failures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace dualpixel::evaluation {
namespace {

/// Beside each bound: what a published library does on such a problem.
TEST(EdgeFailures, StayWithinTheirBounds) {
  std::map<std::string, double> figures;
  for (const EdgeFailure& failure : edge_failures()) figures[failure.name] = solve_failure(failure);
  for (const auto& [name, figure] : figures) EXPECT_TRUE(std::isfinite(figure)) << name;
  EXPECT_LT(figures.at("255 cells across"), 1e-6);                   // .49: the other border's value
  EXPECT_LT(figures.at("edge of 16 levels"), 1);                     // 0
  EXPECT_LE(figures.at("edge of 8 levels"), 2);                      // 0
  EXPECT_LT(figures.at("edge of 2 levels"), 144);                    // 144: no filter that quantizes sees it
  EXPECT_LT(figures.at("region that no confidence reaches"), 1e-6);  // 0 or NaN
  EXPECT_LT(figures.at("no confidence at all"), 1e-6);               // 0 or NaN
  // With a quadratic loss every solver follows the mean: share x 0.7, minus the effect of smoothing at borders.
  EXPECT_NEAR(figures.at("1 % confident outliers"), 0.007, 0.002);
  EXPECT_NEAR(figures.at("5 % confident outliers"), 0.035, 0.003);
  EXPECT_NEAR(figures.at("20 % confident outliers"), 0.14, 0.005);
  EXPECT_LT(figures.at("20 % confident outliers, robust"), 0.005);
  EXPECT_LT(figures.at("flat guide"), 0.0025);                       // .0025
  EXPECT_LT(figures.at("guide of white noise, 24 levels"), 0.0025);  // .003
  EXPECT_LT(figures.at("guide of white noise, 255 levels"), 0.1);    // .095: every pixel is an island, none smooths
  EXPECT_LT(figures.at("smooth guide, smooth target"), 3 - 1);       // 30 - 1
}

}  // namespace
}  // namespace dualpixel::evaluation
