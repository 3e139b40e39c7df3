#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "capture/error.h"
#include "pipeline/disparity/tile_disparity.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "pipeline/disparity/likelihood/interpolate.h"
#include "tests/pipeline/disparity/shift_bound.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kViewWidth = 384, kViewHeight = 96;
constexpr int kBorder = 2;  // tiles at the left and right border, which have less of the other view

// 100 lux: 811 electrons a DP sample (mean 0.25 here), four half-photosites' read noise of 2.4 electrons each.
constexpr ViewNoise kNoise{0.25f / 811, 4 * 2.4f * 2.4f * (0.25f / 811) * (0.25f / 811)};

void add_view_noise(Image& view, unsigned seed, const ViewNoise& noise = kNoise) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  for (float& value : view.data) value += normal(random) * std::sqrt(noise.shot * std::max(value, 0.0f) + noise.read);
}

struct Pair {
  Image left, right;  // noise-free
  double disparity = 0;
};

/// Mean 0.25; contrast is the root mean square over the mean.
Pair shifted_pair(unsigned seed, double highest, double contrast, double d) {
  const Texture texture(seed, highest);
  const double amplitude = 0.25 * contrast * std::numbers::sqrt2;
  return {textured(texture, kViewWidth, kViewHeight, 0, 0.25, amplitude),
          textured(texture, kViewWidth, kViewHeight, d, 0.25, amplitude), d};
}

/// A texture seen through mirrored half discs of diameter |b|, uniform; the disparity is that of their centroids.
Pair defocused_pair(unsigned seed, double highest, double contrast, double b) {
  const int steps = std::abs(b) < 3 ? 10 : 18;
  const double radius = std::abs(b) / 2;
  Pair pair;
  double centroid = 0;
  int points = 0;
  const Texture texture(seed, highest, 24);
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps / 2; ++i) {
      const double x = (i + 0.5) / steps * 2 * radius, y = ((j + 0.5) / steps * 2 - 1) * radius;
      if (x * x + y * y > radius * radius) continue;
      const double side = b > 0 ? x : -x;
      const Image l = texture.raster(kViewWidth, kViewHeight, 0.5 + side, 1, 0.5 - y, 1);
      const Image r = texture.raster(kViewWidth, kViewHeight, 0.5 - side, 1, 0.5 - y, 1);
      if (points == 0) pair.left = pair.right = Image(kViewWidth, kViewHeight);
      for (std::size_t k = 0; k < l.data.size(); ++k) {
        pair.left.data[k] += l.data[k];
        pair.right.data[k] += r.data[k];
      }
      centroid += side;
      ++points;
    }
  }
  const double amplitude = 0.25 * contrast * std::numbers::sqrt2 / points;
  for (Image* view : {&pair.left, &pair.right}) {
    for (float& value : view->data) value = static_cast<float>(0.25 + amplitude * value);
  }
  pair.disparity = 2 * centroid / points;
  return pair;
}

struct Errors {
  double bias = 0;        // mean error
  double efficiency = 0;  // mean over tiles of 1 / (variance over bound^2); variance about each tile's own mean
  double within_one = 0;  // share of errors under one predicted sigma
  double within_two = 0;
  double outliers = 0;  // share of errors over 0.5 px
  int tiles = 0;
};

/// Over tiles whose bound is under `most`, in `frames` pairs of noisy views.
Errors errors_of(const Pair& pair, int frames, double most = 0.1, unsigned seed = 100) {
  const Image bound = shift_bound_dp_px(pair.left, kNoise);
  Image sum(bound.width, bound.height), squares(bound.width, bound.height);
  Errors errors;
  double count = 0;
  for (int frame = 0; frame < frames; ++frame) {
    Image left = pair.left, right = pair.right;
    add_view_noise(left, seed + 2 * frame);
    add_view_noise(right, seed + 2 * frame + 1);
    const TileDisparity tiles = match_by_likelihood(left, right, {.noise = kNoise});
    for (int y = 0; y < bound.height; ++y) {
      for (int x = kBorder; x < bound.width - kBorder; ++x) {
        if (!(bound.at(x, y) < most)) continue;
        const double error = tiles.disparity_dp_px.at(x, y) - pair.disparity;
        sum.at(x, y) += static_cast<float>(error);
        squares.at(x, y) += static_cast<float>(error * error);
        errors.bias += error;
        errors.within_one += std::abs(error) < tiles.sigma_dp_px.at(x, y);
        errors.within_two += std::abs(error) < 2 * tiles.sigma_dp_px.at(x, y);
        errors.outliers += std::abs(error) > 0.5;
        count += 1;
      }
    }
  }
  double variances = 0;
  for (std::size_t i = 0; i < bound.data.size(); ++i) {
    if (squares.data[i] == 0) continue;
    variances += (squares.data[i] - sum.data[i] * sum.data[i] / frames) / (frames - 1) /
                 (static_cast<double>(bound.data[i]) * bound.data[i]);
    ++errors.tiles;
  }
  errors.efficiency = errors.tiles / variances;
  errors.bias /= count;
  errors.within_one /= count;
  errors.within_two /= count;
  errors.outliers /= count;
  return errors;
}

double mean_of(const Image& image) {
  double sum = 0;
  for (const float value : image.data) sum += value;
  return sum / static_cast<double>(image.data.size());
}

/// Share of inner tiles that err by more than 0.5 px although the predicted sigma is under 0.2 px.
double overconfident_errors(const TileDisparity& tiles, double d) {
  int wrong = 0, count = 0;
  for (int y = 0; y < tiles.sigma_dp_px.height; ++y) {
    for (int x = kBorder; x < tiles.sigma_dp_px.width - kBorder; ++x) {
      wrong += std::abs(tiles.disparity_dp_px.at(x, y) - d) > 0.5 && tiles.sigma_dp_px.at(x, y) < 0.2f;
      ++count;
    }
  }
  return static_cast<double>(wrong) / count;
}

TEST(SincTaps, InterpolateWaves) {
  for (const double frequency : {0.02, 0.1, 0.2, 0.26}) {
    for (const float fraction : {0.0f, 0.1f, 0.5f, 0.73f}) {
      const SincTaps taps = sinc_taps(fraction);
      double in_phase = 0, quadrature = 0, slope = 0, third = 0, third_quadrature = 0;
      for (int k = 0; k < 8; ++k) {
        const double angle = 2 * std::numbers::pi * frequency * (k - 3 - fraction);
        in_phase += taps.value[k] * std::cos(angle);
        quadrature += taps.value[k] * std::sin(angle);
        slope += taps.slope[k] * std::sin(angle);
        third -= taps.third[k] * std::sin(angle);
        third_quadrature += taps.third[k] * std::cos(angle);
      }
      EXPECT_NEAR(in_phase, 1, 0.02);
      EXPECT_NEAR(std::atan2(quadrature, in_phase) / (2 * std::numbers::pi * frequency), 0, 0.003);
      EXPECT_NEAR(slope / (2 * std::numbers::pi * frequency), 1, 0.04);
      const double waves_third = std::pow(2 * std::numbers::pi * frequency, 3);
      const double error = std::hypot(third - waves_third, third_quadrature);
      EXPECT_LT(error, (frequency > 0.2 ? 0.2 : frequency > 0.1 ? 0.07 : 0.02) * waves_third);
    }
  }
}

TEST(SincTaps, NoiseCovariancesAreThoseOfWhiteNoise) {
  for (const float fraction : {0.1f, 0.25f, 0.5f, 0.8f}) {
    const SincTaps taps = sinc_taps(fraction);
    double value_value = 0, slope_slope = 0, slope_smooth = 0, smooth_smooth = 0;
    for (int row = -1; row <= 1; ++row) {
      for (int k = -1; k < 9; ++k) {
        double smooth = 0;  // weight of this pixel in the slope of the smoothed view
        for (int i = -1; i <= 1; ++i) {
          if (k + i >= 0 && k + i < 8) smooth += taps.slope[k + i] * (i == 0 ? 0.5 : 0.25) * (row == 0 ? 0.5 : 0.25);
        }
        smooth_smooth += smooth * smooth;
        if (row != 0 || k < 0 || k > 7) continue;
        slope_smooth += smooth * taps.slope[k];
        slope_slope += taps.slope[k] * taps.slope[k];
        value_value += taps.value[k] * taps.value[k];
      }
    }
    EXPECT_NEAR(taps.value_value, value_value, 1e-3);  // interpolated between entries of a table
    EXPECT_NEAR(taps.slope_slope, slope_slope, 1e-3);
    EXPECT_NEAR(taps.slope_smooth, slope_smooth, 1e-3);
    EXPECT_NEAR(taps.smooth_smooth, smooth_smooth, 1e-3);
  }
}

TEST(ShiftBound, IsThatOfAWave) {
  Image view(64, 16);
  constexpr double kFrequency = 1.0 / 8, kAmplitude = 0.1;  // a whole period a tile: the mean of cos^2 is 1/2
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      view.at(x, y) = static_cast<float>(0.5 + kAmplitude * std::sin(2 * std::numbers::pi * kFrequency * x));
    }
  }
  const double slope = 2 * std::numbers::pi * kFrequency * kAmplitude;
  const Image bound = shift_bound_dp_px(view, {0, 1e-4f});
  EXPECT_NEAR(bound.at(4, 1), std::sqrt(2 * 1e-4 / (64 * slope * slope / 2)), 2e-3 * bound.at(4, 1));
  const Image nothing = shift_bound_dp_px(Image(64, 16, 1, 0.5f), {0, 1e-4f});
  for (const float value : nothing.data) EXPECT_TRUE(std::isinf(value));
}

TEST(EstimateNoise, FindsShotNoiseUnderTexture) {
  // 576 tiles' lower quartile: about 2 % of sampling error. The texture, up to 0.1 cycles a pixel, adds little.
  for (const double contrast : {0.0, 0.3}) {
    Pair pair = shifted_pair(4, 0.1, contrast, 0);
    add_view_noise(pair.left, 1, {3e-4f, 0});
    add_view_noise(pair.right, 2, {3e-4f, 0});
    EXPECT_NEAR(estimate_noise(pair.left, pair.right).shot, 3e-4, 0.08 * 3e-4) << contrast;
  }
  const Image flat(32, 32, 1, 0.5f);
  EXPECT_GT(estimate_noise(flat, flat).shot, 0);
}

/// A texture with up to `highest` cycles a pixel along x and `highest_y` along y, with shot noise.
Image noisy_texture(unsigned seed, double contrast, double highest, double highest_y, float shot) {
  Image view = Texture(seed, highest).raster(512, 384, 0.5, 1, 0.5, highest_y / highest);
  for (float& value : view.data) value = static_cast<float>(0.25 * (1 + contrast * value));
  add_view_noise(view, seed, {shot, 0});
  return view;
}

/// Twice as many rows: each of the sensor's, and the mean of two between them; or both a quarter from them.
Image with_rows_between(const Image& sensor, float nearer) {
  Image view(sensor.width, 2 * sensor.height - 2);
  for (int y = 0; y < view.height; ++y) {
    const int above = y / 2, below = above + 1;
    const float share = nearer == 1 ? 1 - 0.5f * static_cast<float>(y % 2) : y % 2 == 0 ? nearer : 1 - nearer;
    for (int x = 0; x < view.width; ++x) {
      view.at(x, y) = share * sensor.at(x, above) + (1 - share) * sensor.at(x, below);
    }
  }
  return view;
}

// Phones deliver views of half as many rows with the rows between interpolated: half of the rows have the noise of one
// of the sensor's, the others half of its variance; or all have 5/8 of it. The quartile of tiles whose rows share their
// noise lies 8 to 16 % lower than that of white noise.
TEST(EstimateNoise, FindsTheNoiseOfInterpolatedRows) {
  for (const double contrast : {0.0, 0.3}) {
    const Image left = noisy_texture(1, contrast, 0.1, 0.1, 3e-4f), right = noisy_texture(2, contrast, 0.1, 0.1, 3e-4f);
    for (const auto& [nearer, share] : {std::pair{1.0f, 0.75}, {0.75f, 0.625}}) {
      const double shot = estimate_noise(with_rows_between(left, nearer), with_rows_between(right, nearer)).shot;
      EXPECT_NEAR(shot, 0.88 * share * 3e-4, 0.1 * share * 3e-4) << contrast << ' ' << nearer;
    }
  }
}

TEST(EstimateNoise, StreaksAreNoInterpolatedRows) {
  // boards, curtains, hair: three rows apart they differ by 12 times what they do three columns apart
  const Image left = noisy_texture(1, 0.1, 0.4, 0.08, 1e-5f), right = noisy_texture(2, 0.1, 0.4, 0.08, 1e-5f);
  EXPECT_LT(estimate_noise(left, right).shot, 2e-5);
}

TEST(EstimateNoise, NarrowViewsHaveNoColumnsFarApart) {
  Image strip(12, 16000, 1, 0.25f);
  add_view_noise(strip, 1, {3e-4f, 0});
  for (const bool interpolated : {false, true}) {
    const Image view = interpolated ? with_rows_between(strip, 1) : strip;
    const double share = interpolated ? 0.75 / 6 : 1;  // differences of neighboring rows show a sixth and less
    EXPECT_NEAR(estimate_noise(view, view).shot, share * 3e-4, 0.2 * share * 3e-4) << interpolated;
  }
}

TEST(LikelihoodMatch, ShiftsOfBandLimitedTextureAreUnbiased) {
  for (const double highest : {0.5, 0.4, 0.25}) {
    for (int sixteenths = 0; sixteenths <= 16; ++sixteenths) {
      const Pair pair = shifted_pair(5, highest, 0.3, sixteenths / 16.0);
      const TileDisparity tiles = match_by_likelihood(pair.left, pair.right, {.noise = ViewNoise{1e-5f, 1e-7f}});
      double sum = 0;
      int count = 0;
      for (int y = 0; y < tiles.disparity_dp_px.height; ++y) {
        for (int x = kBorder; x < tiles.disparity_dp_px.width - kBorder; ++x) {
          sum += tiles.disparity_dp_px.at(x, y) - pair.disparity;
          ++count;
        }
      }
      EXPECT_NEAR(sum / count, 0, 0.005) << highest << " " << pair.disparity;
    }
  }
}

TEST(LikelihoodMatch, SignIsThatOfTheRightViewsShiftOverTheWholeRange) {
  for (const double d : {-14.3, -6.0, -1.5, 2.6, 9.7, 15.2}) {
    const Pair pair = shifted_pair(9, 0.3, 0.2, d);
    const TileDisparity tiles = match_by_likelihood(pair.left, pair.right, {.noise = kNoise});
    for (int y = 0; y < tiles.disparity_dp_px.height; ++y) {
      for (int x = kBorder; x < tiles.disparity_dp_px.width - kBorder; ++x) {
        EXPECT_NEAR(tiles.disparity_dp_px.at(x, y), d, 0.05) << x << " " << y;
      }
    }
  }
}

TEST(LikelihoodMatch, ReachesTheBoundInFocus) {
  // Some 500 tiles, 6 frames: the efficiency's own standard deviation is about 3 %.
  for (const double contrast : {0.1, 0.2}) {
    for (const double d : {0.0, 0.3, -0.85}) {
      const Errors errors = errors_of(shifted_pair(7, 0.35, contrast, d), 6);
      EXPECT_GT(errors.tiles, 400);
      EXPECT_GT(errors.efficiency, 0.8) << contrast << " " << d;
      EXPECT_NEAR(errors.bias, 0, 0.005) << contrast << " " << d;
    }
  }
  for (const double b : {1.0, 2.0, -2.0}) EXPECT_GT(errors_of(defocused_pair(7, 0.35, 0.2, b), 6).efficiency, 0.7) << b;
}

TEST(LikelihoodMatch, PredictsItsErrors) {
  // 68.3 and 95.4 % of normal errors; 3 points are asked for. At least 2000 samples each: 1 point of sampling error.
  // Seeds and bands that no constant was chosen on.
  struct Case {
    unsigned seed;
    double highest, contrast, d;
  };
  for (const Case& c : {Case{21, 0.3, 0.12, 0.45}, {22, 0.4, 0.25, -0.6}, {23, 0.25, 0.2, 0.2}}) {
    const Errors errors = errors_of(shifted_pair(c.seed, c.highest, c.contrast, c.d), 5, 0.2, 300);
    EXPECT_GT(errors.tiles, 400);
    EXPECT_NEAR(errors.within_one, 0.68, 0.03) << c.seed;
    EXPECT_NEAR(errors.within_two, 0.95, 0.03) << c.seed;
  }
}

TEST(SlowLikelihoodMatch, PredictsItsErrorsUnderDefocus) {
  // Seeds that no constant was chosen on.
  double one = 0, two = 0, count = 0;
  for (const double b : {2.0, 3.0, -4.0}) {
    for (const auto& [seed, highest] : {std::pair{51u, 0.35}, {52u, 0.25}, {53u, 0.15}}) {
      const Errors errors = errors_of(defocused_pair(seed, highest, 0.15, b), 3, 0.2, 500);
      one += errors.within_one, two += errors.within_two, count += 1;
    }
  }
  EXPECT_NEAR(one / count, 0.68, 0.03);
  EXPECT_NEAR(two / count, 0.95, 0.03);
}

TEST(SlowLikelihoodMatch, PredictsItsErrorsUnderMoreDefocusOnAverage) {
  // Beyond 4 px of blur each texture's own centroid error, up to 0.13 px, takes over: single ones have 61 to 80 % here
  // (38 to 88 % of all that were measured). Their mean has a standard deviation of 2.5 points.
  double one = 0, two = 0, count = 0;
  for (const auto& [seed, highest] :
       {std::pair{71u, 0.35}, {72u, 0.25}, {73u, 0.15}, {74u, 0.4}, {75u, 0.1}, {76u, 0.2}, {77u, 0.3}, {78u, 0.12}}) {
    const Errors errors = errors_of(defocused_pair(seed, highest, 0.15, 6), 3, 0.2, 500);
    one += errors.within_one, two += errors.within_two, count += 1;
  }
  EXPECT_NEAR(one / count, 0.68, 0.05);
  EXPECT_NEAR(two / count, 0.95, 0.03);
}

TEST(LikelihoodMatch, ATileThatStandsAloneHasLowConfidence) {
  const Texture surface(9, 0.3), other(10, 0.3);
  Image left = textured(surface, kViewWidth, kViewHeight, 0, 0.25, 0.07),
        right = textured(surface, kViewWidth, kViewHeight, 0.5, 0.25, 0.07);
  const Image a = textured(other, kViewWidth, kViewHeight, 0, 0.25, 0.07),
              b = textured(other, kViewWidth, kViewHeight, 2.5, 0.25, 0.07);
  for (int y = 40; y < 56; ++y) {  // 2 x 2 tiles from (10, 5), as a highlight would show: with another disparity
    std::copy_n(a.row(y) + 78, 20, left.row(y) + 78);
    std::copy_n(b.row(y) + 80, 20, right.row(y) + 80);
  }
  add_view_noise(left, 1);
  add_view_noise(right, 2);
  const TileDisparity tiles = match_by_likelihood(left, right, {.noise = kNoise});
  EXPECT_NEAR(tiles.disparity_dp_px.at(10, 5), 2.5, 0.2);  // its disparity is found ...
  EXPECT_GT(tiles.sigma_dp_px.at(10, 5), 0.3f);            // ... with a large predicted error
  EXPECT_LT(tiles.sigma_dp_px.at(20, 5), 0.15f);
}

TEST(LikelihoodMatch, RoughSurfacesAreDoubted) {
  // Rows of tiles at -0.1 and 0.1 in turn: 3 x 3 of them have a variance of 9/8 (0.01 - 0.01 / 9), a quarter of which
  // counts.
  const Pair up = shifted_pair(61, 0.3, 0.2, 0.1), down = shifted_pair(61, 0.3, 0.2, -0.1);
  Pair rough = up;
  for (int y = 0; y < kViewHeight; ++y) {
    if (y / 8 % 2 == 0) std::copy_n(down.right.row(y), kViewWidth, rough.right.row(y));
  }
  const auto mean_sigma = [](const Pair& pair) {
    Image left = pair.left, right = pair.right;
    add_view_noise(left, 1);
    add_view_noise(right, 2);
    const Image sigma = match_by_likelihood(left, right, {.noise = kNoise}).sigma_dp_px;
    double sum = 0;
    for (int y = 1; y + 1 < sigma.height; ++y) {
      for (int x = kBorder; x < sigma.width - kBorder; ++x) sum += sigma.at(x, y);
    }
    return sum / ((sigma.height - 2) * (sigma.width - 2 * kBorder));
  };
  const double even = mean_sigma(up);
  EXPECT_LT(even, 0.04);
  EXPECT_NEAR(mean_sigma(rough), std::sqrt(even * even + 0.25 * 0.01), 0.006);
}

TEST(LikelihoodMatch, BordersAreNoHighlights) {
  // What a border tile cannot use is outside, not clipped. With 6 columns of 8 its variance is 8/6 of an inner one's;
  // with 4, at a shift that pools neighbors, theirs. Ratios of means over some fifty tiles: 5 % of sampling error.
  for (const auto& [d, expected] : {std::pair{0.2, std::sqrt(8.0 / 6)}, {4.0, 1.0}}) {
    Pair pair = shifted_pair(62, 0.3, 0.2, d);
    add_view_noise(pair.left, 1);
    add_view_noise(pair.right, 2);
    const Image sigma = match_by_likelihood(pair.left, pair.right, {.noise = kNoise}).sigma_dp_px;
    double inner = 0, outer = 0;
    for (int y = 0; y < sigma.height; ++y) {
      inner += sigma.at(kBorder + 1, y) + sigma.at(sigma.width - kBorder - 2, y);
      outer += sigma.at(0, y) + sigma.at(sigma.width - 1, y);
    }
    EXPECT_NEAR(outer / inner, expected, 0.1 * expected) << d;
  }
}

TEST(LikelihoodMatch, TakesOutShading) {
  Pair pair = shifted_pair(12, 0.3, 0.2, 0.4);
  for (int y = 0; y < kViewHeight; ++y) {
    for (int x = 0; x < kViewWidth; ++x) {
      pair.left.at(x, y) *= 1 + 0.3f * static_cast<float>(x) / kViewWidth;
      pair.right.at(x, y) *= 1.3f - 0.3f * static_cast<float>(x) / kViewWidth;
    }
  }
  const Errors errors = errors_of(pair, 3);
  EXPECT_NEAR(errors.bias, 0, 0.006);
  EXPECT_GT(errors.efficiency, 0.8);
}

TEST(LikelihoodMatch, ConfidenceIsTheFormulaOfSigma) {
  Pair pair = shifted_pair(9, 0.3, 0.1, 0.5);
  add_view_noise(pair.left, 1);
  add_view_noise(pair.right, 2);
  const TileDisparity tiles = match_by_likelihood(pair.left, pair.right, {.noise = kNoise});
  for (int x = kBorder; x < tiles.confidence.width - kBorder; ++x) {
    const double sigma = tiles.sigma_dp_px.at(x, 5);
    EXPECT_NEAR(tiles.confidence.at(x, 5), 1 / (1 + sigma * sigma / 0.09), 1e-5);
  }
}

TEST(LikelihoodMatch, NothingToSeeHasLowConfidence) {
  Image flat_left(kViewWidth, kViewHeight, 1, 0.25f), flat_right = flat_left;
  add_view_noise(flat_left, 1);
  add_view_noise(flat_right, 2);
  EXPECT_LT(mean_of(match_by_likelihood(flat_left, flat_right, {.noise = kNoise}).confidence), 0.02);

  Image rows_left(kViewWidth, kViewHeight), rows_right;  // structure parallel to the baseline
  for (int y = 0; y < kViewHeight; ++y) std::fill_n(rows_left.row(y), kViewWidth, y % 5 < 2 ? 0.2f : 0.4f);
  rows_right = rows_left;
  add_view_noise(rows_left, 1);
  add_view_noise(rows_right, 2);
  EXPECT_LT(mean_of(match_by_likelihood(rows_left, rows_right, {.noise = kNoise}).confidence), 0.02);
}

TEST(LikelihoodMatch, RepetitionHasLowConfidence) {
  for (const double period : {3.5, 4.0, 5.0, 7.3, 11.0}) {
    Image left(kViewWidth, kViewHeight), right(kViewWidth, kViewHeight);
    for (int y = 0; y < kViewHeight; ++y) {
      for (int x = 0; x < kViewWidth; ++x) {
        const auto wave = [&](double at) {
          return static_cast<float>(0.25 + 0.08 * std::sin(2 * std::numbers::pi * at / period));
        };
        left.at(x, y) = wave(x);
        right.at(x, y) = wave(x - 0.6);
      }
    }
    add_view_noise(left, 1);
    add_view_noise(right, 2);
    const TileDisparity tiles = match_by_likelihood(left, right, {.noise = kNoise});
    EXPECT_LT(mean_of(tiles.confidence), 0.05) << period;
    EXPECT_LT(overconfident_errors(tiles, 0.6), 0.01) << period;
  }
}

TEST(LikelihoodMatch, DisparityBeyondTheRangeHasLowConfidence) {
  for (const double d : {17.0, 20.0, -25.0}) {
    Pair pair = shifted_pair(9, 0.3, 0.2, d);
    add_view_noise(pair.left, 1);
    add_view_noise(pair.right, 2);
    const TileDisparity tiles = match_by_likelihood(pair.left, pair.right, {.noise = kNoise});
    EXPECT_LT(overconfident_errors(tiles, d), 0.01) << d;
    EXPECT_LT(mean_of(tiles.confidence), 0.1) << d;
  }
}

TEST(LikelihoodMatch, SmallAndBrokenViewsAreFiniteAndRefusedWhereTheyDiffer) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 500}, {9, 9}, {200, 1}, {61, 45}}) {
    for (const float fill : {0.0f, 0.5f, 1.0f, std::numeric_limits<float>::quiet_NaN(), INFINITY, -1.0f, -1e30f}) {
      const Image constant(width, height, 1, fill);
      for (const float confidence : match_by_likelihood(constant, constant).confidence.data) EXPECT_EQ(confidence, 0);
    }
    Image left = textured(Texture(3, 0.3), width, height, 0), right = textured(Texture(3, 0.3), width, height, 1);
    left.data.back() = std::numeric_limits<float>::quiet_NaN();
    right.data.front() = -INFINITY;
    const TileDisparity tiles = match_by_likelihood(left, right);
    EXPECT_EQ(tiles.disparity_dp_px.width, (width + 7) / 8);
    EXPECT_EQ(tiles.sigma_dp_px.height, (height + 7) / 8);
    for (const float d : tiles.disparity_dp_px.data) EXPECT_LE(std::abs(d), 16);
    for (const float sigma : tiles.sigma_dp_px.data) EXPECT_TRUE(sigma >= 0 && sigma <= 16);
    for (const float confidence : tiles.confidence.data) EXPECT_TRUE(confidence >= 0 && confidence <= 1);
  }
  EXPECT_TRUE(match_by_likelihood({}, {}).confidence.empty());
  EXPECT_THROW(match_by_likelihood(Image(8, 8), Image(8, 9)), InputError);
  EXPECT_THROW(match_by_likelihood(Image(8, 8, 3), Image(8, 8, 3)), InputError);
  EXPECT_THROW(match_by_likelihood(Image(8, 8), Image(8, 8), {.range_px = 1}), InputError);
  EXPECT_THROW(match_by_likelihood(Image(8, 8), Image(8, 8), {.noise = ViewNoise{-1, 0}}), InputError);
}

TEST(LikelihoodMatch, DoesNotDependOnThreads) {
  Pair pair = shifted_pair(9, 0.3, 0.2, 3.5);
  add_view_noise(pair.left, 1);
  add_view_noise(pair.right, 2);
  const TileDisparity all = match_by_likelihood(pair.left, pair.right, {.noise = kNoise});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TileDisparity alone = match_by_likelihood(pair.left, pair.right, {.noise = kNoise});
  EXPECT_EQ(all.disparity_dp_px.data, alone.disparity_dp_px.data);
  EXPECT_EQ(all.sigma_dp_px.data, alone.sigma_dp_px.data);
}

TEST(LikelihoodMatch, BrokenPixelsSpoilOnlyTheirTiles) {
  Pair pair = shifted_pair(9, 0.3, 0.2, 0.5);
  pair.left.at(100, 40) = std::numeric_limits<float>::quiet_NaN();
  pair.right.at(200, 40) = 1.0f;  // clipped
  const TileDisparity tiles = match_by_likelihood(pair.left, pair.right, {.noise = kNoise});
  for (int y = 0; y < tiles.disparity_dp_px.height; ++y) {
    for (int x = kBorder; x < tiles.disparity_dp_px.width - kBorder; ++x) {
      EXPECT_NEAR(tiles.disparity_dp_px.at(x, y), 0.5, std::max(0.02f, 2 * tiles.sigma_dp_px.at(x, y)))
          << x << " " << y;
    }
  }
  EXPECT_GT(mean_of(tiles.confidence), 0.8);
}

TEST(SlowLikelihoodMatch, StrongDefocusHasFewOutliers) {
  for (const double b : {4.0, 8.0, -8.0, 12.0, -12.0}) {
    const Errors errors = errors_of(defocused_pair(7, b < 5 && b > -5 ? 0.35 : 0.12, 0.4, b), 4);
    EXPECT_LE(errors.outliers, 0.02) << b;
    RecordProperty("efficiency at " + std::to_string(b), std::to_string(errors.efficiency));
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
