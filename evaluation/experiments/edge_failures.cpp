#include "evaluation/experiments/edge_failures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/edge_aware/bilateral_grid.h"
#include "pipeline/edge_aware/bilateral_solver.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kSize = 256;

/// `of` gives each pixel's value.
Image painted(int width, int height, int channels, const std::function<double(int x, int y)>& of) {
  Image image(width, height, channels);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto value = static_cast<float>(of(x, y));
      for (int c = 0; c < channels; ++c) image.at(x, y, c) = value;
    }
  }
  return image;
}

Image constant(double value, int channels = 1) {
  return painted(kSize, kSize, channels, [=](int, int) { return value; });
}

double rmse_to(const Image& result, double truth) {
  double sum = 0;
  for (const float value : result.data) sum += (value - truth) * (value - truth);
  return std::sqrt(sum / static_cast<double>(result.data.size()));
}

double mean_of(const Image& result) {
  double sum = 0;
  for (const float value : result.data) sum += value;
  return sum / static_cast<double>(result.data.size());
}

/// Pixels along the middle row between 10 % and 90 % of the step from 0 to 1.
double step_width(const Image& result) {
  const float* row = result.row(result.height / 2);
  return static_cast<double>(
      std::count_if(row, row + result.width, [](float value) { return value > 0.1f && value < 0.9f; }));
}

/// Mean step between neighbors along a row where a cell begins, over that elsewhere, minus 1.
double blockiness(const Image& result) {
  double at_borders = 0, elsewhere = 0;
  int borders = 0, others = 0;
  for (int y = 0; y < result.height; ++y) {
    for (int x = 1; x < result.width; ++x) {
      const double step = std::abs(result.at(x, y) - result.at(x - 1, y));
      (x % 8 == 0 ? at_borders : elsewhere) += step;
      ++(x % 8 == 0 ? borders : others);
    }
  }
  return at_borders / borders / std::max(elsewhere / others, 1e-9) - 1;
}

EdgeFailure smooth_guide() {
  EdgeFailure failure;
  failure.name = "smooth guide, smooth target";
  failure.figure_name = "steps at cells' borders over steps elsewhere, minus 1";
  failure.guide = painted(kSize, kSize, 3, [](int x, int y) { return 60 + 0.3 * x + 0.2 * y; });
  failure.target = painted(kSize, kSize, 1, [](int x, int y) { return (x + 0.5 * y) / kSize; });
  failure.confidence = constant(1);
  failure.figure = blockiness;
  return failure;
}

/// As many cells across as a hash of base 255 wraps at.
EdgeFailure border_leak() {
  constexpr int kWidth = 255 * 8, kHeight = 64;
  EdgeFailure failure;
  failure.name = "255 cells across";
  failure.figure_name = "error at the left border";
  failure.guide = painted(kWidth, kHeight, 3, [](int, int) { return 100; });
  failure.target = painted(kWidth, kHeight, 1, [](int x, int) { return x < kWidth / 2 ? 0 : 1; });
  failure.confidence = painted(kWidth, kHeight, 1, [](int, int) { return 1; });
  failure.figure = [](const Image& result) { return std::abs(result.at(0, kHeight / 2)); };
  return failure;
}

bool isolated(int x, int y) { return x >= 96 && x < 160 && y >= 96 && y < 160; }

/// A bright region in the middle without confidence; the targets there are 0.
EdgeFailure unreachable() {
  EdgeFailure failure;
  failure.name = "region that no confidence reaches";
  failure.figure_name = "largest error inside";
  failure.guide = painted(kSize, kSize, 3, [](int x, int y) { return isolated(x, y) ? 220 : 40; });
  failure.target = painted(kSize, kSize, 1, [](int x, int y) { return isolated(x, y) ? 0 : 0.7; });
  failure.confidence = painted(kSize, kSize, 1, [](int x, int y) { return isolated(x, y) ? 0 : 1; });
  failure.figure = [](const Image& result) {
    double largest = 0;
    for (int y = 96; y < 160; ++y) {
      for (int x = 96; x < 160; ++x) largest = std::max(largest, std::abs(result.at(x, y) - 0.7));
    }
    return largest;
  };
  return failure;
}

EdgeFailure no_confidence() {
  EdgeFailure failure;
  failure.name = "no confidence at all";
  failure.figure_name = "RMSE";
  failure.guide = constant(100, 3);
  failure.target = constant(0.5);
  failure.confidence = constant(0);
  failure.figure = [](const Image& result) { return rmse_to(result, 0.5); };
  return failure;
}

/// A step of the target from 0 to 1, with noise and no confidence near it; the guide is missing.
EdgeFailure noisy_step(unsigned draw) {
  std::mt19937 random(1 + draw);
  std::normal_distribution<double> noise(0, 0.05);
  EdgeFailure failure;
  failure.figure_name = "10-90 % width, px";
  failure.target = painted(kSize, kSize, 1, [&](int x, int) { return (x < kSize / 2 ? 0 : 1) + noise(random); });
  failure.confidence = painted(kSize, kSize, 1, [](int x, int) { return std::abs(x - kSize / 2) < 16 ? 0 : 1; });
  failure.figure = step_width;
  return failure;
}

/// Pixels on the wrong side of the step.
double misplaced(const Image& result) {
  int count = 0;
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) count += (result.at(x, y) > 0.5f) != (x >= result.width / 2);
  }
  return count;
}

constexpr double kDark = 98;  // of the guide: two levels above a cell's border

}  // namespace

EdgeFailure edge_of_levels(double levels, unsigned draw) {
  EdgeFailure failure = noisy_step(draw);
  failure.name = fmt::format("edge of {:g} levels", levels);
  failure.guide = painted(kSize, kSize, 3, [=](int x, int) { return x < kSize / 2 ? kDark : kDark + levels; });
  return failure;
}

EdgeFailure edge_with_gap(double gap_px, unsigned draw) {
  constexpr double kLevels = 64;
  constexpr int kDeep_px = 32;
  EdgeFailure failure = noisy_step(draw);
  failure.name = fmt::format("edge with a gap of {:g} px", gap_px);
  failure.figure_name = "pixels on the wrong side";
  failure.figure = misplaced;
  failure.guide = painted(kSize, kSize, 3, [=](int x, int y) {
    const int from_middle = y - kSize / 2;
    const bool in_gap =
        from_middle >= -std::floor(gap_px / 2) && from_middle < std::ceil(gap_px / 2) && x < kSize / 2 + kDeep_px;
    return x < kSize / 2 || in_gap ? kDark : kDark + kLevels;
  });
  return failure;
}

EdgeFailure confident_outliers(double share, int robust_rounds, unsigned draw) {
  std::mt19937 random(2 + draw);
  std::uniform_real_distribution<double> uniform;
  EdgeFailure failure;
  failure.name = fmt::format("{:g} % confident outliers{}", 100 * share, robust_rounds > 0 ? ", robust" : "");
  failure.figure_name = "mean error";
  failure.guide = constant(100, 3);
  failure.target = painted(kSize, kSize, 1, [&](int, int) { return uniform(random) < share ? 0.9 : 0.2; });
  failure.confidence = constant(1);
  failure.options.robust_rounds = robust_rounds;
  failure.figure = [](const Image& result) { return std::abs(mean_of(result) - 0.2); };
  return failure;
}

EdgeFailure noisy_guide(double spread, unsigned draw) {
  std::mt19937 random(3 + draw);
  std::normal_distribution<double> noise(0, 0.1);
  std::uniform_real_distribution<float> level(static_cast<float>(127 - spread / 2),
                                              static_cast<float>(127 + spread / 2));
  EdgeFailure failure;
  failure.name = spread > 0 ? fmt::format("guide of white noise, {:g} levels", spread) : "flat guide";
  failure.figure_name = "RMSE; target .1";
  failure.guide = constant(127, 3);
  if (spread > 0) {
    for (float& value : failure.guide.data) value = level(random);
  }
  failure.target = painted(kSize, kSize, 1, [&](int, int) { return 0.5 + noise(random); });
  failure.confidence = constant(1);
  failure.figure = [](const Image& result) { return rmse_to(result, 0.5); };
  return failure;
}

std::vector<EdgeFailure> edge_failures() {
  return {border_leak(),
          edge_of_levels(2),
          edge_of_levels(4),
          edge_of_levels(8),
          edge_of_levels(16),
          unreachable(),
          no_confidence(),
          confident_outliers(0.01, 0),
          confident_outliers(0.05, 0),
          confident_outliers(0.2, 0),
          confident_outliers(0.2, 5),
          noisy_guide(0),
          noisy_guide(8),
          noisy_guide(24),
          noisy_guide(255),
          smooth_guide()};
}

Image solve(const EdgeFailure& failure) {
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(failure.guide);
  return pipeline::solve_bilateral(grid, failure.guide, failure.target, failure.confidence, failure.options).value;
}

double solve_failure(const EdgeFailure& failure) { return failure.figure(solve(failure)); }

}  // namespace dualpixel::evaluation
