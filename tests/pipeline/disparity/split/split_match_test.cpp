#include "pipeline/disparity/split/split_match.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "capture/error.h"
#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/split/split_filters.h"
#include "tests/pipeline/ramp_pair.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kRampBorder = 6;  // tiles: a window's reach, mirrored there

struct RampErrors {
  double bias = 0, wrong = 0, within_one = 0, within_two = 0;
};

RampErrors ramp_errors(const TileDisparity& tiles, double d) {
  RampErrors errors;
  int count = 0;
  for (int y = kRampBorder; y < tiles.disparity_dp_px.height - kRampBorder; ++y) {
    for (int x = kRampBorder; x < tiles.disparity_dp_px.width - kRampBorder; ++x) {
      const double error = tiles.disparity_dp_px.at(x, y) - d, sigma = tiles.sigma_dp_px.at(x, y);
      errors.bias += error;
      errors.wrong += std::abs(error) > 0.5;
      errors.within_one += std::abs(error) < sigma;
      errors.within_two += std::abs(error) < 2 * sigma;
      ++count;
    }
  }
  return {errors.bias / count, errors.wrong / count, errors.within_one / count, errors.within_two / count};
}

TEST(SplitFilters, UndoTheKernelsOfTheirDisparity) {
  // Even filter times the difference plus odd filter times the sum of both views' responses, for waves of three
  // directions: 0 but for what four separable terms leave out, of 1.
  struct Case {
    double d, height, alpha;
  };
  for (const auto& [d, height, alpha] : {Case{1, 1, kRampAlpha},
                                         {3, 1, kRampAlpha},
                                         {6, 1, kRampAlpha},
                                         {3, 2, kRampAlpha},
                                         {6, 2, kRampAlpha},
                                         {3, 1, kHalvesAlpha},
                                         {9, 1, kHalvesAlpha},
                                         {9, 2, kHalvesAlpha}}) {
    const split::SplitFilters filters = split::make_filters(d, alpha, {4, height, 0.8});
    for (const double angle : {0.0, 0.5, 1.0}) {
      const double f = 0.06, fx = f * std::cos(angle), fy = f * std::sin(angle);  // cycles a sample
      const auto response = [&](const split::SeparableFilter& filter, bool odd) {
        const auto sum_of = [](const std::vector<float>& taps, double f, bool sine) {
          double sum = sine ? 0 : taps[0];
          for (std::size_t i = 1; i < taps.size(); ++i) {
            const double t = 2 * std::numbers::pi * static_cast<double>(i) * f;
            sum += 2 * taps[i] * (sine ? std::sin(t) : std::cos(t));
          }
          return sum;
        };
        return sum_of(filter.along_x, fx, odd) * sum_of(filter.along_y, fy, false);
      };
      double even = 0, odd = 0;
      for (const split::SeparableFilter& term : filters.difference) even += response(term, false);
      for (const split::SeparableFilter& term : filters.sum) odd += response(term, true);
      // Left is even - odd, right even + odd: the difference is -2 odd, the sum 2 even.
      const Response views = ramp_response(fx / 4, fy / 4 / height, d / alpha, alpha);
      const double size = std::hypot(views.even, views.odd);
      EXPECT_NEAR((views.even * odd - views.odd * even) / size, 0, 0.04) << d << " " << angle;
      EXPECT_GT(std::hypot(even, odd), 0.7) << d << " " << angle;
    }
  }
}

TEST(SlowSplitMatch, SoftSplitsAreUnbiasedBeforeAndBehindTheFocus) {
  // Bias and wrong share as asked of the matcher; what a single texture is off by lies within both.
  for (const double noise : {0.0, 0.003}) {
    for (const double b : {-30.0, -24.0, -15.0, -6.0, 6.0, 12.0, 20.0, 30.0}) {
      const RampPair pair = ramp_pair(3, b, noise);
      const RampErrors errors = ramp_errors(match_by_split(pair.left, pair.right), pair.disparity);
      EXPECT_NEAR(errors.bias, 0, 0.05) << b << " noise " << noise;
      EXPECT_LT(errors.wrong, 0.05) << b << " noise " << noise;
      EXPECT_GT(errors.within_one, 0.6) << b << " noise " << noise;
      EXPECT_GT(errors.within_two, 0.88) << b << " noise " << noise;
    }
  }
}

// A phone's DP pixels of 2 x 4 photosites are twice as high as wide, so that a round blur is flat in them. Taken for
// square, .92 and all of the tiles are wrong; what a single texture is off by lies within the limits.
TEST(SlowSplitMatch, KnowsThatPixelsAreHigh) {
  for (const double b : {-30.0, 40.0}) {
    const RampPair pair = ramp_pair(3, b, 0.003, kRampAlpha, 2);
    const RampErrors errors = ramp_errors(match_by_split(pair.left, pair.right, {.pixel_height = 2}), pair.disparity);
    EXPECT_NEAR(errors.bias, 0, 0.06) << b;
    EXPECT_LT(errors.wrong, 0.05) << b;
    EXPECT_GT(errors.within_one, 0.6) << b;
    EXPECT_GT(ramp_errors(match_by_split(pair.left, pair.right), pair.disparity).wrong, 0.5) << b;
  }
}

// Halves that share no light, where the camera says so; taken for a phone's ramp, most tiles are wrong.
TEST(SlowSplitMatch, KnowsOtherSplits) {
  for (const double b : {-20.0, 12.0}) {
    const RampPair pair = ramp_pair(3, b, 0.003, kHalvesAlpha);
    const RampErrors errors =
        ramp_errors(match_by_split(pair.left, pair.right, {.alpha = static_cast<float>(kHalvesAlpha)}), pair.disparity);
    EXPECT_NEAR(errors.bias, 0, 0.05) << b;
    EXPECT_LT(errors.wrong, 0.05) << b;
    EXPECT_GT(errors.within_two, 0.88) << b;
    EXPECT_GT(ramp_errors(match_by_split(pair.left, pair.right), pair.disparity).wrong, 0.5) << b;
  }
}

/// The part of a pair at (x0, y0).
RampPair cropped(const RampPair& pair, int x0, int y0, int width, int height) {
  RampPair part{Image(width, height), Image(width, height), pair.disparity};
  for (int y = 0; y < height; ++y) {
    std::copy_n(pair.left.row(y0 + y) + x0, width, part.left.row(y));
    std::copy_n(pair.right.row(y0 + y) + x0, width, part.right.row(y));
  }
  return part;
}

// A narrow window of the views' local ratio takes disparity for shading: with one of 16 px on so small a picture all is
// too near to the focus by a tenth. Means over four parts of a picture, with as much noise as the other tests have.
TEST(SlowSplitMatch, SmallPicturesKeepTheirDisparity) {
  for (const double b : {8.0, 16.0, -24.0}) {
    const RampPair pair = ramp_pair(5, b, 0.003, kRampAlpha, 2);
    double bias = 0;
    for (const int x : {20, 260}) {
      for (const int y : {10, 130}) {
        const RampPair part = cropped(pair, x, y, 224, 112);
        bias += 0.25 * ramp_errors(match_by_split(part.left, part.right, {.pixel_height = 2}), pair.disparity).bias;
      }
    }

    EXPECT_NEAR(bias, 0, 0.05) << b;
  }
}

/// Share of the two outermost columns of tiles that is wrong by more than `limit_px`.
double wrong_at_the_border(double b, int left_out_px, double limit_px) {
  int wrong = 0, count = 0;
  for (const unsigned seed : {5, 6}) {
    const RampPair pair =
        cropped(ramp_pair(seed, b, 0.003, kRampAlpha, 2), 0, 0, kRampWidth - left_out_px, kRampHeight - left_out_px);
    const TileDisparity tiles = match_by_split(pair.left, pair.right, {.pixel_height = 2});
    const int columns = tiles.disparity_dp_px.width;
    for (int y = 0; y < tiles.disparity_dp_px.height; ++y) {
      for (const int x : {0, 1, columns - 2, columns - 1}) {
        wrong += std::abs(tiles.disparity_dp_px.at(x, y) - pair.disparity) > limit_px;
        ++count;
      }
    }
  }
  return static_cast<double>(wrong) / count;
}

// Mirrored at the left and right border, a scene would lie on the other side of the focus: there the views change
// places. If they did not, .18 and .43 of the two outermost columns of tiles would be wrong by .5 px, instead of .02.
TEST(SlowSplitMatch, HoldsAtTheBorder) {
  for (const double b : {12.0, -24.0}) EXPECT_LT(wrong_at_the_border(b, 0, 0.5), 0.05) << b;
}

// Tiles that reach over the border: mirrored without exchanging the views, a seventh to a third was wrong by .5 px.
// What is left there is noise, predicted as .4 px.
TEST(SlowSplitMatch, HoldsAtTheBorderOfAnySize) {
  for (const int left_out_px : {1, 4, 7}) {
    for (const double b : {12.0, -24.0}) {
      EXPECT_LT(wrong_at_the_border(b, left_out_px, 0.5), 0.1) << b << " without " << left_out_px;
      EXPECT_EQ(wrong_at_the_border(b, left_out_px, 0.8), 0) << b << " without " << left_out_px;
    }
  }
}

// Light that falls by a third towards the left of one view and towards the right of the other, near the focus: were it
// left to the ratio of means over windows, a fifth of the outermost columns of tiles would be wrong by .5 px.
TEST(SplitMatch, ShadingIsNotDisparityAtTheBorder) {
  RampPair pair = ramp_pair(7, 2, 0.003);
  for (int y = 0; y < kRampHeight; ++y) {
    for (int x = 0; x < kRampWidth; ++x) {
      const float across = (2 * static_cast<float>(x) + 1) / kRampWidth - 1;
      pair.left.at(x, y) *= 1 + 0.2f * across;
      pair.right.at(x, y) *= 1 - 0.2f * across;
    }
  }
  const TileDisparity tiles = match_by_split(pair.left, pair.right);
  int wrong = 0;
  const int rows = tiles.disparity_dp_px.height, last = tiles.disparity_dp_px.width - 1;
  for (int y = 0; y < rows; ++y) {
    for (const int x : {0, last}) wrong += std::abs(tiles.disparity_dp_px.at(x, y) - pair.disparity) > 0.5;
  }
  EXPECT_LT(wrong, 0.05 * 2 * rows);
}

// A sky that clips behind roofs, but for what noise leaves below white. A window there sees little: taken for a whole
// one, a sixteenth would be wrong by more than two deviations.
TEST(SplitMatch, WhatClipsIsNotKnownFromItsRim) {
  constexpr float kWhite = 0.5;
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  int beyond = 0, count = 0;
  for (const unsigned seed : {5, 6, 7}) {
    RampPair pair = ramp_pair(seed, 2, 0.003);
    for (int y = 0; y < kRampHeight; ++y) {
      for (int x = 0; x < kRampWidth; ++x) {
        const int roof = kRampHeight / 2 - (x / 64 % 2) * 24;
        if (y >= roof) continue;
        for (Image* view : {&pair.left, &pair.right}) {
          view->at(x, y) = std::min(kWhite, 1.02f * kWhite * (1 + 0.03f * normal(random)));
        }
      }
    }
    const TileDisparity tiles = match_by_split(pair.left, pair.right, {.white = kWhite});
    for (int y = 0; y < kRampHeight / 16 - 5; ++y) {
      for (int x = 0; x < tiles.disparity_dp_px.width; ++x, ++count) {
        beyond += std::abs(tiles.disparity_dp_px.at(x, y) - pair.disparity) > 2 * tiles.sigma_dp_px.at(x, y);
      }
    }
  }
  EXPECT_LT(beyond, 0.01 * count);
}

// A lamp far behind the focus has the ratio of a lens's shading across its disc, and outshines all else: the wall
// before it keeps its disparity.
TEST(SplitMatch, ALampOutOfFocusIsNotShading) {
  const RampPair plain = ramp_pair(7, 2, 0.003);
  RampPair lit = plain;
  constexpr double kX = 330, kY = 120, kRadius = 32;
  for (int y = 0; y < kRampHeight; ++y) {
    for (int x = 0; x < kRampWidth; ++x) {
      const double across = (x - kX) / kRadius, down = (y - kY) / kRadius;
      if (across * across + down * down > 1) continue;
      lit.left.at(x, y) += static_cast<float>(9 * (1 + 4 * kRampAlpha * across));
      lit.right.at(x, y) += static_cast<float>(9 * (1 - 4 * kRampAlpha * across));
    }
  }
  SplitMatchOptions options;
  options.white = 100;
  const TileDisparity tiles = match_by_split(lit.left, lit.right, options);
  int wrong = 0, count = 0;
  for (int y = 0; y < tiles.disparity_dp_px.height; ++y) {
    for (int x = 0; x < tiles.disparity_dp_px.width; ++x) {
      if (std::hypot(8 * x + 4 - kX, 8 * y + 4 - kY) < 3.5 * kRadius) continue;
      wrong += std::abs(tiles.disparity_dp_px.at(x, y) - plain.disparity) > 0.5;
      ++count;
    }
  }
  EXPECT_LT(wrong, 0.01 * count);
}

// Sharp highlights before a blurred wall, over four times as bright: around them most of the wall keeps its disparity.
// Were their contrast to count in full, half would get theirs; .28 do.
TEST(SplitMatch, HighlightsAnswerForLessOfWhatIsAroundThem) {
  RampPair pair = ramp_pair(7, 20, 0.003);
  constexpr int kStep = 128, kSide = 6;
  constexpr float kBright = 1;
  for (int y = kStep / 2; y < kRampHeight; y += kStep) {
    for (int x = kStep / 2; x < kRampWidth; x += kStep) {
      for (int i = 0; i < kSide * kSide; ++i) {
        for (Image* view : {&pair.left, &pair.right}) view->at(x + i % kSide, y + i / kSide) += kBright;
      }
    }
  }
  const TileDisparity tiles = match_by_split(pair.left, pair.right, {.white = 100});
  int wrong = 0, count = 0;
  for (int y = 0; y < tiles.disparity_dp_px.height; ++y) {
    for (int x = 0; x < tiles.disparity_dp_px.width; ++x) {
      const double across = (8 * x + 4) % kStep - (kStep + kSide) / 2.0;
      const double down = (8 * y + 4) % kStep - (kStep + kSide) / 2.0;
      const double away = std::hypot(across, down);
      if (away < 24 || away > 44) continue;
      wrong += std::abs(tiles.disparity_dp_px.at(x, y) - pair.disparity) > 0.5;
      ++count;
    }
  }
  EXPECT_LT(wrong, 0.35 * count);
}

/// Share of the tiles, 8 to 32 px beside the edge of something in focus, whose disparity is wrong by .5 px: of a plane
/// at blur `b` behind it.
double wrong_beside_edge(double b, double noise, const SplitMatchOptions& options, const SkewField& skew) {
  const RampPair sharp = ramp_pair(4, 0.5, noise), behind = ramp_pair(5, b, noise);
  RampPair pair = behind;
  for (const auto& [from, to] : {std::pair{&sharp.left, &pair.left}, {&sharp.right, &pair.right}}) {
    for (int y = 0; y < kRampHeight; ++y) std::copy_n(from->row(y), kRampWidth / 2, to->row(y));
  }
  LikelihoodMatchOptions near_focus;
  near_focus.skew = skew;
  const Image found = match_by_split(pair.left, pair.right, options, near_focus).disparity_dp_px;
  double wrong = 0, count = 0;
  for (int y = 0; y < found.height; ++y) {
    for (int x = kRampWidth / 16 + 1; x < kRampWidth / 16 + 4; ++x) {
      wrong += std::abs(found.at(x, y) - behind.disparity) > 0.5;
      ++count;
    }
  }
  return wrong / count;
}

// Up to 32 px beside something in focus, windows of the coarse search reach over its edge: alone they would give a
// third of the background its disparity. The likelihood matcher's narrower windows leave a tenth.
TEST(SplitMatch, ADepthEdgeIsAsSharpAsNarrowWindowsHaveIt) { EXPECT_LT(wrong_beside_edge(7.5, 0.003, {}, {}), 0.2); }

// Just beyond the limit near the focus the likelihood matcher excludes the focus, but seldom what the coarse search
// finds beside the edge: were it asked to, 15 and 23 % of these tiles would be wrong.
TEST(SplitMatch, ADepthEdgeIsSharpJustBeyondTheLimit) {
  SplitMatchOptions options;
  options.alpha = kRampAlpha;
  const SkewField skew{1, 1, {skew_of_split(kRampAlpha, 1)}};
  for (const double b : {6.3, 7.0}) EXPECT_LT(wrong_beside_edge(b, 0.02, options, skew), 0.1) << b;
}

TEST(SplitMatch, NearTheFocusIsTheLikelihoodMatcher) {
  const RampPair pair = ramp_pair(4, 2, 0.003);
  const TileDisparity ours = match_by_split(pair.left, pair.right);
  const TileDisparity likelihood = match_by_likelihood(pair.left, pair.right, {.range_px = 4});
  EXPECT_EQ(ours.disparity_dp_px.data, likelihood.disparity_dp_px.data);
  EXPECT_EQ(ours.sigma_dp_px.data, likelihood.sigma_dp_px.data);
}

// Where noise hides the texture, what low frequencies find by chance is not believed: two standard deviations let a
// twentieth through.
TEST(SplitMatch, NoiseIsNotFarFromTheFocus) {
  const RampPair pair = ramp_pair(4, 2, 0.15);
  const TileDisparity tiles = match_by_split(pair.left, pair.right);
  double weight = 0, far = 0;
  for (std::size_t i = 0; i < tiles.confidence.data.size(); ++i) {
    weight += tiles.confidence.data[i];
    if (std::abs(tiles.disparity_dp_px.data[i]) > SplitMatchOptions().near_focus_dp_px) far += tiles.confidence.data[i];
  }
  EXPECT_LT(far / weight, 0.1);
}

// Just beyond the limit its own answer alone cannot exclude the focus, but the likelihood matcher's does: the predicted
// error is the answer's own, not its distance from the focus (1.47 px at b = 6.5).
TEST(SplitMatch, JustBeyondTheLimitIsNotTakenForNoise) {
  for (const double b : {-9.0, -6.5, 6.5, 9.0}) {
    const RampPair pair = ramp_pair(4, b, 0.01);
    const TileDisparity tiles = match_by_split(pair.left, pair.right);
    std::vector<float> sigma = tiles.sigma_dp_px.data;
    std::nth_element(sigma.begin(), sigma.begin() + sigma.size() / 10 * 9, sigma.end());
    EXPECT_LT(sigma[sigma.size() / 10 * 9], 0.5) << b;
    EXPECT_GT(ramp_errors(tiles, pair.disparity).within_two, 0.95) << b;
  }
}

// What lies beyond the range is not taken for a sharp thing near the focus, as the likelihood matcher would: by .2 % of
// the tiles here; by 2.3 % were its answer taken wherever the coarse search has none.
TEST(SplitMatch, BeyondTheRangeIsNotNearTheFocus) {
  int near = 0, all = 0;
  for (const double b : {80.0, 95.0, 110.0, 140.0}) {
    const RampPair pair = ramp_pair(3, b, 0);
    const TileDisparity tiles = match_by_split(pair.left, pair.right);
    for (std::size_t i = 0; i < tiles.confidence.data.size(); ++i, ++all) {
      const bool is_near = std::abs(tiles.disparity_dp_px.data[i]) < SplitMatchOptions().near_focus_dp_px;
      near += is_near && tiles.confidence.data[i] > 0.5f ? 1 : 0;
    }
  }
  EXPECT_LT(near, 0.005 * all);
}

TEST(SplitMatch, SameBytesForAnyNumberOfThreads) {
  const RampPair pair = ramp_pair(5, 15, 0.01);
  const auto with_threads = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return match_by_split(pair.left, pair.right);
  };
  const TileDisparity one = with_threads(1), three = with_threads(3);
  EXPECT_EQ(one.disparity_dp_px.data, three.disparity_dp_px.data);
  EXPECT_EQ(one.sigma_dp_px.data, three.sigma_dp_px.data);
  EXPECT_EQ(one.confidence.data, three.confidence.data);
}

TEST(SplitMatch, UnusablePixelsStayFinite) {
  RampPair pair = ramp_pair(6, 10, 0.003);
  for (int y = 40; y < 120; ++y) {
    for (int x = 60; x < 200; ++x) {
      pair.left.at(x, y) = x < 100 ? std::numeric_limits<float>::quiet_NaN() : 2.0f;
    }
  }
  const TileDisparity tiles = match_by_split(pair.left, pair.right);
  for (std::size_t i = 0; i < tiles.disparity_dp_px.data.size(); ++i) {
    EXPECT_TRUE(std::abs(tiles.disparity_dp_px.data[i]) <= 16) << i;
    EXPECT_TRUE(tiles.sigma_dp_px.data[i] > 0 && tiles.sigma_dp_px.data[i] <= 16) << i;
    EXPECT_TRUE(tiles.confidence.data[i] >= 0 && tiles.confidence.data[i] <= 1) << i;
  }
}

// Light that clips, at the border or within, has no disparity of its own, and makes no edge that both views share: the
// matcher finds what it finds in the mirrored pair, whose views change places, but for rounding.
TEST(SplitMatch, ClippedPartsMakeNoEdge) {
  for (const auto& [first, last] : {std::pair{0, 48}, {130, 190}}) {
    RampPair pair = ramp_pair(8, 19, 0.003);
    RampPair mirrored = pair;
    for (int y = 0; y < kRampHeight; ++y) {
      for (Image* view : {&pair.left, &pair.right}) std::fill_n(view->row(y) + first, last - first, 1.5f);
      std::reverse_copy(pair.left.row(y), pair.left.row(y) + kRampWidth, mirrored.right.row(y));
      std::reverse_copy(pair.right.row(y), pair.right.row(y) + kRampWidth, mirrored.left.row(y));
    }
    const Image left = match_by_split(pair.left, pair.right).disparity_dp_px;
    const Image right = match_by_split(mirrored.left, mirrored.right).disparity_dp_px;
    for (int y = 0; y < left.height; ++y) {
      for (int x = 0; x < left.width; ++x) EXPECT_NEAR(left.at(x, y), right.at(left.width - 1 - x, y), 0.01);
    }
    for (int y = 2; y < left.height - 2; ++y) {
      for (int x = last / 8 + 3; x < last / 8 + 8; ++x) EXPECT_NEAR(left.at(x, y), pair.disparity, 1) << first;
    }
  }
}

TEST(SplitMatch, SmallAndEmptyViews) {
  EXPECT_TRUE(match_by_split({}, {}).disparity_dp_px.empty());
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {20, 9}}) {
    const Image view(width, height, 1, 0.3f);
    const TileDisparity tiles = match_by_split(view, view);
    EXPECT_EQ(tiles.disparity_dp_px.width, (width + 7) / 8);
    for (const float d : tiles.disparity_dp_px.data) EXPECT_TRUE(std::isfinite(d));
  }
}

TEST(SplitMatch, RefusesWhatItCannotUse) {
  const Image view(32, 16, 1, 0.3f);
  EXPECT_THROW(match_by_split(view, Image(24, 16, 1, 0.3f)), InputError);
  EXPECT_THROW(match_by_split(Image(32, 16, 3), Image(32, 16, 3)), InputError);
  for (const auto change :
       {+[](SplitMatchOptions& o) { o.alpha = 0.5f; }, +[](SplitMatchOptions& o) { o.alpha = 0.01f; },
        +[](SplitMatchOptions& o) { o.alpha = NAN; }, +[](SplitMatchOptions& o) { o.range_px = 3; },
        +[](SplitMatchOptions& o) { o.window_px = 0; }, +[](SplitMatchOptions& o) { o.near_focus_dp_px = -1; }}) {
    SplitMatchOptions options;
    change(options);
    EXPECT_THROW(match_by_split(view, view, options), InputError);
  }
  SplitMatchOptions options;
  options.alpha = 0.5f;
  try {
    check(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("split_match.alpha: 0.5"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
