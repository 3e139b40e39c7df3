#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "capture/error.h"
#include "capture/image/median.h"
#include "capture/image/resample.h"
#include "pipeline/edge_aware/bilateral_grid.h"
#include "pipeline/edge_aware/bilateral_solver.h"
#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/edge_aware/joint_upsample.h"
#include "pipeline/edge_aware/smooth_disparity.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

Image random_image(int width, int height, int channels, unsigned seed, double low, double high) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(static_cast<float>(low), static_cast<float>(high));
  Image image(width, height, channels);
  for (float& value : image.data) value = uniform(random);
  return image;
}

/// Left part dark, right part bright, with a sharp edge at `edge`.
Image two_tone(int width, int height, int edge, float dark = 40, float bright = 200) {
  Image guide(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) guide.at(x, y, c) = x < edge ? dark : bright;
    }
  }
  return guide;
}

using Cell = std::array<int, 5>;
using Position = std::array<double, 5>;

/// Where a pixel lies along the grid's axes, in cells.
Position position(const Image& guide, int x, int y, const BilateralGridOptions& cells) {
  const int last = guide.channels - 1;
  const double r = guide.at(x, y, 0), g = guide.at(x, y, std::min(1, last)), b = guide.at(x, y, last);
  const double gray = std::ceil(128 / cells.cell_chroma) + 0.5;
  return {(x + 0.5) / cells.cell_px, (y + 0.5) / cells.cell_px, (0.299 * r + 0.587 * g + 0.114 * b) / cells.cell_luma,
          gray + (-0.168736 * r - 0.331264 * g + 0.5 * b) / cells.cell_chroma,
          gray + (0.5 * r - 0.418688 * g - 0.081312 * b) / cells.cell_chroma};
}

struct DenseSolution {
  std::vector<double> value, variance;
};

/// The solver's system from the definition, with dense matrices and cells told apart by a map; the weights of all
/// targets in each vertex by elimination, and each pixel's mean over all vertices from the definition.
DenseSolution dense_solution(const Image& guide, const Image& target, const Image& confidence,
                             const BilateralGridOptions& cells, const BilateralSolverOptions& options) {
  std::map<Cell, int> index;
  std::vector<int> vertex_of_pixel;
  for (int y = 0; y < guide.height; ++y) {
    for (int x = 0; x < guide.width; ++x) {
      const Position at = position(guide, x, y, cells);
      Cell cell;
      for (int axis = 0; axis < 5; ++axis) cell[axis] = static_cast<int>(at[axis]);
      vertex_of_pixel.push_back(index.emplace(cell, static_cast<int>(index.size())).first->second);
    }
  }
  const int size = static_cast<int>(index.size());
  Eigen::MatrixXd blur = Eigen::MatrixXd::Zero(size, size);
  for (const auto& [a, i] : index) {
    for (const auto& [b, j] : index) {
      int distance = 0;
      for (int axis = 0; axis < 5; ++axis) distance += std::abs(a[axis] - b[axis]);
      blur(i, j) = distance == 0 ? 10 : distance == 1 ? 1 : 0;
    }
  }
  Eigen::VectorXd pixels = Eigen::VectorXd::Zero(size), weight = pixels;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(size, 2);  // of the target and its square
  for (std::size_t p = 0; p < vertex_of_pixel.size(); ++p) {
    const double c = confidence.data[p], t = target.data[p];
    pixels[vertex_of_pixel[p]] += 1;
    weight[vertex_of_pixel[p]] += c;
    right.row(vertex_of_pixel[p]) += Eigen::RowVector2d(c * t, c * t * t);
  }
  Eigen::VectorXd n = Eigen::VectorXd::Ones(size);
  for (int k = 0; k < options.bistochastic_iterations; ++k) {
    n = (n.array() * pixels.array() / (blur * n).array()).sqrt().matrix().eval();
  }
  const Eigen::VectorXd m = n.array() * (blur * n).array();
  Eigen::MatrixXd a = -options.lambda * (n.asDiagonal() * blur * n.asDiagonal());
  a.diagonal() += options.lambda * m + weight;
  const Eigen::MatrixXd solved = a.ldlt().solve(right);

  DenseSolution solution;
  for (int y = 0; y < guide.height; ++y) {
    for (int x = 0; x < guide.width; ++x) {
      const Position at = position(guide, x, y, cells);
      double value = 0, variance = 0, weights = 0;
      for (const auto& [cell, i] : index) {
        double near = 1;
        for (int axis = 0; axis < 5; ++axis) near *= std::max(1 - std::abs(at[axis] - cell[axis] - 0.5), 0.0);
        weights += near;
        value += near * solved(i, 0);
        variance += near * (solved(i, 1) - solved(i, 0) * solved(i, 0));
      }
      solution.value.push_back(value / weights);
      solution.variance.push_back(variance / weights);
    }
  }
  return solution;
}

TEST(BilateralSolver, EqualsADenseSolve) {
  struct Case {
    int channels;
    BilateralGridOptions cells;
    float lambda;
  };
  for (const auto& [channels, cells, lambda] : {Case{3, {4, 8, 8}, 4},
                                                {1, {4, 8, 8}, 4},
                                                {3, {8, 4, 4}, 128},
                                                {1, {3, 16, 5}, 1024},
                                                {3, {2.5f, 6, 30}, 0.5f}}) {
    const Image guide = random_image(24, 18, channels, 1, 90, 130);
    const Image target = random_image(24, 18, 1, 2, -1, 1);
    const Image confidence = random_image(24, 18, 1, 3, 0, 1);
    BilateralSolverOptions options;
    options.lambda = lambda;
    options.iterations = 1000;
    options.least_residual = 1e-12;
    options.variance = true;
    const BilateralSolution solved =
        solve_bilateral(make_bilateral_grid(guide, cells), guide, target, confidence, options);
    EXPECT_LE(solved.residual, 1e-12);
    const DenseSolution expected = dense_solution(guide, target, confidence, cells, options);
    for (std::size_t i = 0; i < expected.value.size(); ++i) {
      ASSERT_NEAR(solved.value.data[i], expected.value[i], 1e-5) << channels << ' ' << lambda << ' ' << i;
      ASSERT_NEAR(solved.variance.data[i], expected.variance[i], 1e-5) << channels << ' ' << lambda << ' ' << i;
    }
  }
}

TEST(BilateralGrid, CoordinatesNeverWrap) {
  // A hash of small fields takes column 255's neighbor for column 0 of the next row.
  const int width = 2100;
  const BilateralGrid grid = make_bilateral_grid(Image(width, 2, 3, 100.0f), {4, 8, 8});
  EXPECT_EQ(grid.vertices, width / 4);
  EXPECT_EQ(grid.neighbors[0], grid.vertices);  // nothing to the left of the first
  EXPECT_EQ(grid.neighbors[(grid.vertices - 1) * BilateralGrid::kNeighbors + 1], grid.vertices);
  for (int v = 0; v < grid.vertices; ++v) {
    for (int axis = 1; axis < 5; ++axis) {
      EXPECT_EQ(grid.neighbors[v * BilateralGrid::kNeighbors + 2 * axis], grid.vertices);
      EXPECT_EQ(grid.neighbors[v * BilateralGrid::kNeighbors + 2 * axis + 1], grid.vertices);
    }
  }
}

TEST(BilateralSolver, KeepsEdgesAndSpreadsConfidence) {
  const Image guide = two_tone(64, 48, 32);
  Image target(64, 48), confidence(64, 48);
  for (int y = 0; y < 48; ++y) {
    target.at(4, y) = 0.25f;  // one confident column on either side of the edge
    target.at(60, y) = 0.75f;
    confidence.at(4, y) = confidence.at(60, y) = 1;
  }
  const Image solved = solve_bilateral(make_bilateral_grid(guide), guide, target, confidence).value;
  for (int y = 0; y < 48; ++y) {
    EXPECT_NEAR(solved.at(31, y), 0.25f, 1e-4);
    EXPECT_NEAR(solved.at(32, y), 0.75f, 1e-4);
  }
}

TEST(BilateralSolver, UnreachableRegionsTakeWhatIsAround) {
  Image guide(64, 64, 3, 40.0f);
  Image target(64, 64, 1, 0.7f), confidence(64, 64, 1, 1.0f);
  for (int y = 20; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) {
      for (int c = 0; c < 3; ++c) guide.at(x, y, c) = 220;
      target.at(x, y) = -2;
      confidence.at(x, y) = 0;
    }
  }
  const Image solved = solve_bilateral(make_bilateral_grid(guide), guide, target, confidence).value;
  for (const float value : solved.data) EXPECT_NEAR(value, 0.7f, 1e-4);
}

TEST(BilateralSolver, BrokenAndEmptyInputsStayFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Image guide = random_image(40, 30, 3, 1, 0, 255), target = random_image(40, 30, 1, 2, 0, 1);
  Image confidence(40, 30, 1, 1.0f);
  guide.at(3, 3, 1) = nan;
  target.at(5, 5) = nan;
  target.at(6, 5) = std::numeric_limits<float>::infinity();
  confidence.at(7, 5) = nan;
  const BilateralGrid grid = make_bilateral_grid(guide);
  for (const float value : solve_bilateral(grid, guide, target, confidence).value.data) {
    EXPECT_TRUE(value > -0.5f && value < 1.5f);
  }
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 700}, {700, 1}, {3, 5000}}) {
    const Image constant(width, height, 3, 10.0f);
    const Image solved = solve_bilateral(make_bilateral_grid(constant), constant, Image(width, height, 1, 0.5f),
                                         Image(width, height, 1, 1.0f))
                             .value;
    for (const float value : solved.data) EXPECT_NEAR(value, 0.5f, 1e-5);
  }
}

TEST(BilateralSolver, ConfidenceOfTheResult) {
  // Left and right of an edge the targets agree and differ; in the middle is an island without confidence.
  Image guide = two_tone(96, 64, 48), target(96, 64), confidence(96, 64, 1, 1.0f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) target.at(x, y) = x < 48 ? 0.5f : (x + y) % 2 == 0 ? 0.2f : 0.8f;
  }
  for (int y = 24; y < 40; ++y) {
    for (int x = 16; x < 32; ++x) {
      guide.at(x, y, 0) = 255;
      confidence.at(x, y) = 0;
    }
  }
  BilateralSolverOptions options;
  options.variance = true;
  options.iterations = 200;
  const BilateralSolution solved = solve_bilateral(make_bilateral_grid(guide), guide, target, confidence, options);
  // as a confidence for the result, by Barron and Poole 2016, section 4.1
  Image result_confidence = solved.variance;
  for (float& value : result_confidence.data) value = std::exp(-value / (2 * 0.3f * 0.3f));
  EXPECT_NEAR(result_confidence.at(4, 4), 1, 1e-4);
  EXPECT_NEAR(solved.variance.at(90, 60), 0.09, 1e-3);  // of 0.2 and 0.8
  EXPECT_NEAR(result_confidence.at(90, 60), std::exp(-0.5), 5e-3);
  EXPECT_TRUE(std::isinf(solved.variance.at(24, 32)));
  EXPECT_EQ(result_confidence.at(24, 32), 0);
  EXPECT_NEAR(solved.value.at(24, 32), 0.5f, 1e-4);
}

TEST(ReduceByConfidence, WhatIsUnknownDoesNotMixWithWhatIsKnown) {
  ConfidentMap map{Image(8, 4, 1, 2.0f), Image(8, 4, 1, 0.5f)};
  map.value.at(0, 0) = 100;
  map.confidence.at(0, 0) = 0;
  for (int y = 0; y < 4; ++y) {
    for (int x = 4; x < 8; ++x) {
      map.value.at(x, y) = static_cast<float>(x % 2);
      map.confidence.at(x, y) = 0;
    }
  }
  const ConfidentMap small = reduce_by_confidence(map, 2, 1);
  EXPECT_NEAR(small.value.at(0, 0), 2, 1e-6);
  EXPECT_NEAR(small.confidence.at(0, 0), 0.5 * 15 / 16, 1e-6);
  EXPECT_EQ(small.value.at(1, 0), 0.5f);  // nothing is known: the plain mean
  EXPECT_EQ(small.confidence.at(1, 0), 0);
}

TEST(BilateralSolver, UnreachedPixelsTakeTheNearestReached) {
  Image guide(60, 40, 3, 40.0f), target(60, 40), confidence(60, 40, 1, 1.0f);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      target.at(x, y) = static_cast<float>(x + 3 * y);
      if (x < 15 || x > 45 || y < 12) continue;
      for (int c = 0; c < 3; ++c) guide.at(x, y, c) = 200;
      confidence.at(x, y) = 0;
    }
  }
  const Image solved = solve_bilateral(make_bilateral_grid(guide), guide, target, confidence).value;
  for (int y = 12; y < 40; ++y) {
    for (int x = 15; x <= 45; ++x) {
      double nearest = 1e9;
      std::vector<float> allowed;  // all that are as near
      for (int v = 0; v < 40; ++v) {
        for (int u = 0; u < 60; ++u) {
          if (u >= 15 && u <= 45 && v >= 12) continue;
          const double distance = (u - x) * (u - x) + (v - y) * (v - y);
          if (distance < nearest) allowed.clear();
          if (distance <= nearest) allowed.push_back(solved.at(u, v));
          nearest = std::min(nearest, distance);
        }
      }
      ASSERT_NE(std::find(allowed.begin(), allowed.end(), solved.at(x, y)), allowed.end()) << x << ' ' << y;
    }
  }
}

TEST(BilateralSolver, ChannelsAreSolvedLikeOne) {
  const Image guide = random_image(40, 30, 3, 1, 90, 130), confidence = random_image(40, 30, 1, 2, 0, 1);
  const Image both = random_image(40, 30, 2, 3, 0, 1);
  const BilateralGrid grid = make_bilateral_grid(guide);
  const Image solved = solve_bilateral(grid, guide, both, confidence).value;
  for (int c = 0; c < 2; ++c) {
    Image one(40, 30);
    for (std::size_t i = 0; i < one.data.size(); ++i) one.data[i] = both.data[2 * i + c];
    const Image expected = solve_bilateral(grid, guide, one, confidence).value;
    for (std::size_t i = 0; i < one.data.size(); ++i) ASSERT_EQ(solved.data[2 * i + c], expected.data[i]);
  }
}

TEST(BilateralSolver, StopsWhereAskedAndStartsFromAGuess) {
  const Image guide = random_image(160, 120, 3, 1, 90, 130), confidence = random_image(160, 120, 1, 2, 0, 0.1);
  const Image target = random_image(160, 120, 1, 3, 0, 1);
  const BilateralGrid grid = make_bilateral_grid(guide);
  BilateralSolverOptions options;
  options.iterations = 1000;
  options.least_residual = 1e-4;
  const BilateralSolution solved = solve_bilateral(grid, guide, target, confidence, options);
  EXPECT_LE(solved.residual, 1e-4);
  EXPECT_GT(solved.iterations, 1);
  options.iterations = 2;
  EXPECT_GT(solve_bilateral(grid, guide, target, confidence, options).residual, 1e-4);
  options.iterations = 1000;
  const BilateralSolution again = solve_bilateral(grid, guide, target, confidence, options, solved.value);
  EXPECT_LT(again.iterations, solved.iterations);
  for (std::size_t i = 0; i < target.data.size(); ++i) ASSERT_NEAR(again.value.data[i], solved.value.data[i], 1e-3);
}

TEST(BilateralSolver, SameBytesForAnyNumberOfThreads) {
  const Image guide = random_image(300, 200, 3, 1, 60, 190), target = random_image(300, 200, 1, 2, 0, 1);
  const Image confidence = random_image(300, 200, 1, 3, 0, 1);
  std::vector<Image> results;
  for (const int threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const BilateralGrid grid = make_bilateral_grid(guide);
    results.push_back(joint_upsample(median_3x3(solve_bilateral(grid, guide, target, confidence).value), guide,
                                     resize_bilinear(guide, 600, 400)));
  }
  EXPECT_EQ(results[0].data, results[1].data);
  EXPECT_EQ(results[0].data, results[2].data);
}

TEST(BilateralSolver, RefusesWhatCannotBe) {
  const Image guide(8, 8, 3, 10.0f), map(8, 8);
  EXPECT_THROW(make_bilateral_grid(Image()), InputError);
  EXPECT_THROW(make_bilateral_grid(Image(8, 8, 2)), InputError);
  for (const BilateralGridOptions& cells : {BilateralGridOptions{0.5f, 8, 8}, {8, -1, 8}, {8, 8, std::nanf("")}}) {
    EXPECT_THROW(make_bilateral_grid(guide, cells), InputError);
  }
  const BilateralGrid grid = make_bilateral_grid(guide);
  EXPECT_THROW(solve_bilateral(grid, guide, Image(7, 8), map), InputError);
  EXPECT_THROW(solve_bilateral(grid, guide, map, Image(8, 8, 2)), InputError);
  EXPECT_THROW(solve_bilateral(grid, guide, map, map, {}, Image(8, 7)), InputError);
  EXPECT_THROW(solve_bilateral(grid, guide, map, map, {.lambda = 0}), InputError);
  EXPECT_THROW(solve_bilateral(grid, guide, map, map, {.lambda = std::nanf("")}), InputError);
  EXPECT_THROW(solve_bilateral(grid, guide, map, map, {.iterations = -1}), InputError);
  EXPECT_THROW(solve_bilateral(grid, guide, map, map, {.robust_rounds = 1, .robust_scale = 0}), InputError);
}

TEST(FillGaps, KeepsConfidentValuesAndAveragesAround) {
  Image target(8, 8), confidence(8, 8);
  target.at(1, 1) = 3;
  confidence.at(1, 1) = 1;
  for (const float value : fill_gaps(target, confidence).data) EXPECT_FLOAT_EQ(value, 3);
  target.at(6, 6) = 1;
  confidence.at(6, 6) = 1;
  const Image filled = fill_gaps(target, confidence);
  EXPECT_FLOAT_EQ(filled.at(1, 1), 3);
  EXPECT_FLOAT_EQ(filled.at(6, 6), 1);
  EXPECT_GT(filled.at(0, 0), filled.at(7, 7));
  for (const float value : fill_gaps(target, Image(8, 8)).data) EXPECT_EQ(value, 0);
}

TEST(Median, EqualsSorting) {
  const Image image = random_image(17, 11, 1, 4, 0, 1);
  const Image filtered = median_3x3(image);
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 17; ++x) {
      std::vector<float> window;
      for (int v = y - 1; v <= y + 1; ++v) {
        for (int u = x - 1; u <= x + 1; ++u) window.push_back(image.at(std::clamp(u, 0, 16), std::clamp(v, 0, 10)));
      }
      std::sort(window.begin(), window.end());
      ASSERT_EQ(filtered.at(x, y), window[4]);
    }
  }
  EXPECT_EQ(median_3x3(Image(1, 1, 1, 5.0f)).at(0, 0), 5);
}

TEST(Erode, EqualsTheMinimumOverTheWindow) {
  const Image image = random_image(23, 9, 1, 5, 0, 1);
  for (const int side : {1, 3, 7, 101}) {
    const Image eroded = erode(image, side);
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 23; ++x) {
        float least = 1;
        for (int v = std::max(y - side / 2, 0); v <= std::min(y + side / 2, 8); ++v) {
          for (int u = std::max(x - side / 2, 0); u <= std::min(x + side / 2, 22); ++u) {
            least = std::min(least, image.at(u, v));
          }
        }
        ASSERT_EQ(eroded.at(x, y), least) << side;
      }
    }
  }
}

TEST(Erode, ReachesFromEndToEnd) {
  Image image(23, 9, 1, 1.0f);
  image.at(22, 8) = 0;
  for (const float value : erode(image, 101).data) EXPECT_EQ(value, 0);
}

TEST(GaussianBlur, KeepsConstantsAndHasItsVariance) {
  for (const float value : gaussian_blur(Image(9, 5, 1, 0.3f), 2).data) EXPECT_NEAR(value, 0.3f, 1e-6);
  Image point(41, 41);
  point.at(20, 20) = 1;
  const Image blurred = gaussian_blur(point, 2);
  double sum = 0, variance = 0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      sum += blurred.at(x, y);
      variance += blurred.at(x, y) * (x - 20) * (x - 20);
    }
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  EXPECT_NEAR(variance, 4, 0.12);  // cut at 3 sigma: 2.7 % less
}

TEST(Resample, AreaMeansAndLinearRamps) {
  Image ramp(12, 9, 2);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) {
      ramp.at(x, y, 0) = static_cast<float>(x) + 0.5f;
      ramp.at(x, y, 1) = static_cast<float>(y) + 0.5f;
    }
  }
  const Image reduced = resize_area(ramp, 4, 3);
  for (int x = 0; x < 4; ++x) EXPECT_NEAR(reduced.at(x, 0, 0), (x + 0.5) * 3, 1e-5);
  for (int y = 0; y < 3; ++y) EXPECT_NEAR(reduced.at(0, y, 1), (y + 0.5) * 3, 1e-5);
  // 2.4 by 1: all of columns 0 and 1, 0.4 of column 2.
  EXPECT_NEAR(resize_area(ramp, 5, 9).at(0, 0, 0), (0.5 + 1.5 + 0.4 * 2.5) / 2.4, 1e-5);
  const Image enlarged = resize_bilinear(ramp, 48, 18);
  for (int x = 2; x < 46; ++x) EXPECT_NEAR(enlarged.at(x, 5, 0), (x + 0.5) / 4, 1e-5);
  for (int y = 1; y < 17; ++y) EXPECT_NEAR(enlarged.at(7, y, 1), (y + 0.5) / 2, 1e-5);
}

TEST(JointUpsample, FollowsTheGuidesEdgeWithinASmallPixel) {
  // The edge lies at 33, inside the small pixel of columns 32 to 35.
  const Image guide = two_tone(64, 40, 33);
  const Image small_guide = resize_area(guide, 16, 10);
  Image small(16, 10);
  for (int y = 0; y < 10; ++y) {
    for (int x = 8; x < 16; ++x) small.at(x, y) = 1;
  }
  small.at(8, 5) = 0.75f;  // mixed, like the small guide there
  const Image large = joint_upsample(small, small_guide, guide);
  for (int y = 0; y < 40; ++y) {
    EXPECT_LT(large.at(31, y), 0.05f);
    EXPECT_LT(large.at(32, y), 0.05f);
    EXPECT_GT(large.at(33, y), 0.95f);
    EXPECT_GT(large.at(34, y), 0.95f);
  }
}

TEST(JointUpsample, EqualsTheDefinition) {
  const Image guide = random_image(22, 13, 3, 7, 80, 160);
  const Image small_guide = resize_area(guide, 6, 5);
  const Image small = random_image(6, 5, 1, 8, 0, 1);
  const Image large = joint_upsample(small, small_guide, guide);
  for (int y = 0; y < 13; ++y) {
    for (int x = 0; x < 22; ++x) {
      const double at_x = (x + 0.5) * 6 / 22, at_y = (y + 0.5) * 5 / 13;
      double sum = 0, weights = 0;
      for (int v = static_cast<int>(at_y) - 1; v <= static_cast<int>(at_y) + 1; ++v) {
        for (int u = static_cast<int>(at_x) - 1; u <= static_cast<int>(at_x) + 1; ++u) {
          const int i = std::clamp(u, 0, 5), j = std::clamp(v, 0, 4);
          double difference = 0;
          for (int c = 0; c < 3; ++c) difference += std::pow(small_guide.at(i, j, c) - guide.at(x, y, c), 2);
          const double distance = std::pow(u + 0.5 - at_x, 2) + std::pow(v + 0.5 - at_y, 2);
          const double weight =
              std::exp(-distance / (2 * 0.25)) * (std::pow(std::max(1 - difference / (2 * 256) / 16, 0.0), 16) + 1e-6);
          sum += weight * small.at(i, j);
          weights += weight;
        }
      }
      ASSERT_NEAR(large.at(x, y), sum / weights, 1e-4) << x << ' ' << y;
    }
  }
}

TEST(Guide, BrightensAndClips) {
  EXPECT_FLOAT_EQ(guide_gain(Image(4, 4, 3, 0.05f)), 4);
  EXPECT_FLOAT_EQ(guide_gain(Image(4, 4, 3, 0.5f)), 1);
  EXPECT_FLOAT_EQ(guide_gain(Image(4, 4, 3, 0.0f)), 1);
  Image rgb(1, 1, 3);
  rgb.data = {0.25f, std::numeric_limits<float>::quiet_NaN(), 7.0f};
  const Image guide = encode_guide(rgb, 1);
  EXPECT_FLOAT_EQ(guide.data[0], 127.5f);
  EXPECT_EQ(guide.data[1], 0);
  EXPECT_EQ(guide.data[2], 255);
}

TEST(FilterMask, SnapsACoarseMaskToThePicturesEdge) {
  const Image guide = two_tone(240, 160, 117);
  Image mask(30, 20);  // one cell is 8 px; the true edge is 3 px from one of its borders
  for (int y = 0; y < 20; ++y) {
    for (int x = 15; x < 30; ++x) mask.at(x, y) = 1;
  }
  const Image filtered = filter_mask(mask, guide);
  ASSERT_TRUE(filtered.same_size(guide));
  for (int y = 0; y < 160; ++y) {
    EXPECT_LT(filtered.at(113, y), 0.1f);
    EXPECT_GT(filtered.at(121, y), 0.9f);
  }
  for (const float value : filter_mask(Image(1, 1, 1, 1.0f), Image(1, 1, 3, 9.0f)).data) EXPECT_GT(value, 0.99f);
}

TEST(FilterMask, SwitchedOffOnlyChangesTheSize) {
  const Image guide = two_tone(240, 160, 117);
  Image mask(30, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) mask.at(x, y) = static_cast<float>(x) / 29;
  }
  FilterMaskOptions off;
  set_field(fields(off), "on=0");
  const Image large = filter_mask(mask, guide, off);
  ASSERT_TRUE(large.same_size(guide));
  // a ramp stays one: pixel x of 240 lies at (x + 1/2) / 8 - 1/2 of 30, whatever the picture's edges
  for (int x = 4; x < 236; ++x) EXPECT_NEAR(large.at(x, 80), ((x + 0.5) / 8 - 0.5) / 29, 1e-5) << x;
  const Image small = filter_mask(large, two_tone(30, 20, 15), off);
  for (int x = 1; x < 29; ++x) EXPECT_NEAR(small.at(x, 10), static_cast<double>(x) / 29, 1e-5) << x;
  EXPECT_THROW(set_field(fields(off), "on=2"), InputError);
}

}  // namespace
}  // namespace dualpixel::pipeline
