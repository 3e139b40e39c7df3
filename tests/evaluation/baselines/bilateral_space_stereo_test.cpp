#include "evaluation/baselines/bilateral_space_stereo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "capture/error.h"
#include "evaluation/baselines/lbfgs.h"

namespace dualpixel::evaluation {
namespace {

/// Smooth texture along a row, continuous in x.
float texture(double x, int y) {
  return static_cast<float>(120 + 60 * std::sin(0.9 * x + 1.7 * y) + 40 * std::sin(0.37 * x - 0.6 * y));
}

struct Views {
  Image left, right;
};

/// right(x + d) = left(x).
template <typename Disparity>
Views textured_views(int width, int height, const Disparity& disparity_at) {
  Views views{Image(width, height), Image(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      views.left.at(x, y) = texture(x, y);
      views.right.at(x, y) = texture(x - disparity_at(x), y);
    }
  }
  return views;
}

TEST(MatchIntervals, HoldTheTrueShift) {
  MatchIntervalOptions options;
  options.noise_levels = 1;
  for (const double shift : {-0.75, 0.0, 0.5}) {
    const Views views = textured_views(64, 12, [&](int) { return shift; });
    const MatchIntervals found = match_intervals(views.left, views.right, options);
    double width = 0;
    int within = 0;
    for (std::size_t i = 0; i < found.first.data.size(); ++i) {
      const float low = options.dp_px_of(found.first.data[i]), high = options.dp_px_of(found.last.data[i]);
      within += low <= shift + 1e-6 && shift <= high + 1e-6;
      width += high - low;
    }
    // curvature between samples costs some pixels; all others enclose the shift tightly
    EXPECT_GE(within, 0.9 * 64 * 12) << shift;
    EXPECT_LT(width / (64 * 12), 0.75) << shift;
  }
}

TEST(MatchIntervals, APixelWithoutTextureOrMatchSaysNothing) {
  const MatchIntervalOptions options;
  const MatchIntervals flat = match_intervals(Image(9, 5, 1, 80.0f), Image(9, 5, 1, 82.0f), options);
  const MatchIntervals none = match_intervals(Image(9, 5, 1, 80.0f), Image(9, 5, 1, 90.0f), options);
  for (const MatchIntervals* found : {&flat, &none}) {
    EXPECT_EQ(found->first.at(4, 2), 0);
    EXPECT_EQ(found->last.at(4, 2), 16);
  }
}

TEST(MatchIntervals, AWindowNeedsAllOfItsPixels) {
  MatchIntervalOptions options;
  options.window_columns = 5;
  options.window_rows = 3;
  Image right(15, 7);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 15; ++x) right.at(x, y) = 80.0f + 8.0f * static_cast<float>(x - 7);  // a ramp: one label alone
  }
  Image left = right;
  left.at(7, 3) = 250;  // matches nowhere
  const MatchIntervals found = match_intervals(left, right, options);
  for (int y = 0; y < 7; ++y) {
    for (int x = 2; x < 13; ++x) {
      const bool spoiled = std::abs(x - 7) <= 2 && std::abs(y - 3) <= 1;
      // beside the spike interpolation reaches it within half a step
      if (!spoiled && std::abs(x - 7) <= 3 && std::abs(y - 3) <= 1) continue;
      EXPECT_EQ(found.last.at(x, y) - found.first.at(x, y) == 16, spoiled) << x << ", " << y;
    }
  }
}

TEST(MatchIntervals, BadInputIsRefused) {
  MatchIntervalOptions options;
  EXPECT_THROW(match_intervals(Image(4, 4), Image(5, 4), options), InputError);
  options.labels = 16;
  EXPECT_THROW(match_intervals(Image(4, 4), Image(4, 4), options), InputError);
}

TEST(Lbfgs, FindsTheMinimumOfAQuadratic) {
  // 1/2 x' A x - b' x with A = [[4, 1], [1, 3]], b = [1, 2]: x = [1, 7] / 11
  const auto f = [](const std::vector<double>& x, std::vector<double>& g) {
    g = {4 * x[0] + x[1] - 1, x[0] + 3 * x[1] - 2};
    return 0.5 * (4 * x[0] * x[0] + 2 * x[0] * x[1] + 3 * x[1] * x[1]) - x[0] - 2 * x[1];
  };
  const std::vector<double> x = minimize_lbfgs(f, {5, -8}, 40);
  EXPECT_NEAR(x[0], 1.0 / 11, 1e-6);
  EXPECT_NEAR(x[1], 7.0 / 11, 1e-6);
}

/// Three vertices in a row: gray steps of one cell each.
struct ThreeVertices {
  ThreeVertices() : guide(24, 8, 3), intervals{Image(24, 8), Image(24, 8, 1, 16.0f)} {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 24; ++x) {
        const int vertex = x / 8;
        std::fill_n(&guide.at(x, y), 3, 100.0f + 8.0f * static_cast<float>(vertex));
      }
    }
    // the first knows that it is at 3 to 5, the last at 11 to 12 with a quarter of its pixels at 14, the middle nothing
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 24; ++x) {
        if (x < 8) intervals.first.at(x, y) = 3, intervals.last.at(x, y) = 5;
        if (x >= 16) intervals.first.at(x, y) = y < 2 ? 14 : 11, intervals.last.at(x, y) = y < 2 ? 14 : 12;
      }
    }
    grid = pipeline::make_bilateral_grid(guide, {8, 8, 8});
  }
  Image guide;
  MatchIntervals intervals;
  pipeline::BilateralGrid grid;
};

TEST(BilateralSpace, EnergyIsThatOfItsDefinition) {
  const ThreeVertices scene;
  ASSERT_EQ(scene.grid.vertices, 3);
  BilateralSpaceOptions options;
  options.lambda = 0.5;
  options.bistochastic_iterations = 400;
  const BilateralSpaceEnergy energy(scene.grid, scene.intervals, 17, options);
  std::vector<double> gradient(3), zero(3);
  // A constant costs no smoothness. The first vertex lies 3 beyond its intervals, the last 3 and 6 before its own
  EXPECT_NEAR(energy({8, 8, 8}, gradient), 0.5 * (64 * 3 + 48 * 3 + 16 * 6), 1e-6);
  // The cells differ along x and along Y at once, so no two are neighbors: nothing ties them. Beyond the labels every
  // pixel of the middle vertex pulls
  EXPECT_NEAR(energy({4, 20, 11.5}, gradient), 0.5 * (64 * 4 + 16 * 2.5), 1e-6);
}

// Two tiles of 64 pixels, neighbors along x, and data that says nothing. B is [[10, 1], [1, 10]] there, so that both
// have n^2 = 64 / 11, and Dm - Dn B Dn is n^2 [[1, -1], [-1, 1]].
TEST(BilateralSpace, SmoothnessOfTwoNeighborsHasAClosedForm) {
  const Image guide(16, 8, 3, 100.0f);
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(guide, {8, 8, 8});
  ASSERT_EQ(grid.vertices, 2);
  const MatchIntervals anything{Image(16, 8), Image(16, 8, 1, 16.0f)};
  const BilateralSpaceEnergy energy(grid, anything, 17, {});
  std::vector<double> gradient(2);
  EXPECT_NEAR(energy({3, 7}, gradient), 0.5 * 64 / 11 * 16, 1e-9);
  EXPECT_NEAR(gradient[0], -4 * 64.0 / 11, 1e-9);
  EXPECT_NEAR(gradient[1], 4 * 64.0 / 11, 1e-9);
}

/// Guide without steps, so that the tiles are neighbors along x.
TEST(BilateralSpace, FindsWhatBruteForceFinds) {
  ThreeVertices scene;
  std::fill(scene.guide.data.begin(), scene.guide.data.end(), 100.0f);
  scene.grid = pipeline::make_bilateral_grid(scene.guide, {8, 8, 8});
  ASSERT_EQ(scene.grid.vertices, 3);
  for (const double lambda : {0.02, 0.1, 1.0}) {
    BilateralSpaceOptions options;
    options.lambda = lambda;
    options.iterations = 200;
    const BilateralSpaceEnergy energy(scene.grid, scene.intervals, 17, options);
    std::vector<double> gradient(3);
    double least = 1e30;
    constexpr double kStep = 0.125;
    for (double a = 0; a <= 16; a += kStep) {
      for (double b = 0; b <= 16; b += kStep) {
        for (double c = 0; c <= 16; c += kStep) least = std::min(least, energy({a, b, c}, gradient));
      }
    }
    const std::vector<double> found = solve_bilateral_space(scene.grid, scene.intervals, 17, options);
    EXPECT_LE(energy(found, gradient), 1.001 * least + 1e-9) << lambda;
  }
}

/// The gradient against differences, away from kinks.
TEST(BilateralSpace, GradientIsThatOfTheEnergy) {
  ThreeVertices scene;
  std::fill(scene.guide.data.begin(), scene.guide.data.end(), 100.0f);
  scene.grid = pipeline::make_bilateral_grid(scene.guide, {8, 8, 8});
  const BilateralSpaceEnergy energy(scene.grid, scene.intervals, 17, {});
  const std::vector<double> at = {2.3, 9.4, 13.6};
  std::vector<double> gradient(3), unused(3);
  energy(at, gradient);
  for (int j = 0; j < 3; ++j) {
    std::vector<double> before = at, after = at;
    before[j] -= 1e-4, after[j] += 1e-4;
    EXPECT_NEAR(gradient[j], (energy(after, unused) - energy(before, unused)) / 2e-4, 1e-5);
  }
}

TEST(BilateralSpace, PyramidJoinsPairsOfCells) {
  Image guide(64, 32, 3, 100.0f);
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(guide, {8, 8, 8});
  ASSERT_EQ(grid.vertices, 32);
  const auto parents = grid_pyramid(grid, 3);
  ASSERT_EQ(parents.size(), 2u);
  EXPECT_EQ(1 + *std::max_element(parents[0].begin(), parents[0].end()), 8);
  EXPECT_EQ(1 + *std::max_element(parents[1].begin(), parents[1].end()), 2);
  EXPECT_EQ(parents[0][0], parents[0][9]);
  EXPECT_NE(parents[0][0], parents[0][2]);
}

/// Pictures of 256 x 96 px over views of 128 x 24, as a phone has them.
Image picture_of(int width, int height, int step_at) {
  Image rgb(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) std::fill_n(&rgb.at(x, y), 3, x < step_at ? 0.1f : 0.5f);
  }
  return rgb;
}

Views linear(Views views) {
  for (Image* view : {&views.left, &views.right}) {
    for (float& value : view->data) value = value * value / (255.0f * 255.0f) / 2;
  }
  return views;
}

TEST(BilateralSpaceStereo, APlaneIsFlatAndAStepFollowsThePicture) {
  BilateralSpaceStereoOptions options;
  options.match.noise_levels = 1;
  const Image flat_picture = picture_of(256, 96, 0);
  for (const double shift : {-0.5, 0.25}) {
    const Views views = linear(textured_views(128, 24, [&](int) { return shift; }));
    const Image disparity = bilateral_space_stereo(views.left, views.right, flat_picture, options);
    for (const float d : disparity.data) ASSERT_NEAR(d, shift, 0.13);  // a step is .125
  }
  const Views step = linear(textured_views(128, 24, [](int x) { return x < 64 ? -0.5 : 0.5; }));
  const Image disparity = bilateral_space_stereo(step.left, step.right, picture_of(256, 96, 128), options);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 256; ++x) {
      const float truth = x < 128 ? -0.5f : 0.5f, d = disparity.at(x, y);
      ASSERT_GT(d * truth, 0) << x << ", " << y;  // the edge is the picture's, to the pixel
      // windows of 5 DP px, 10 px of the picture, know nothing where they lie on both sides
      if (std::abs(x - 127.5f) <= 10) continue;
      ASSERT_NEAR(d, truth, 0.15) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
