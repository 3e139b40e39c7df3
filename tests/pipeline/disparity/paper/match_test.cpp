#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/disparity/paper/match.h"
#include "pipeline/disparity/paper/normalize.h"
#include "pipeline/disparity/tile_disparity.h"
#include "pipeline/disparity/upsample.h"
#include "pipeline/segmentation/merge_mask.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kTextureWidth = 256, kTextureHeight = 64;

TileDisparity match_shifted(double d, double highest_frequency, double noise = 0, double contrast = 0.1,
                            unsigned seed = 5) {
  const Texture texture(seed, highest_frequency);
  Image left = textured(texture, kTextureWidth, kTextureHeight, 0, 0.5, contrast);
  Image right = textured(texture, kTextureWidth, kTextureHeight, d, 0.5, contrast);  // right(x + d) = left(x)
  if (noise > 0) {
    add_white_noise(left, 1, noise);
    add_white_noise(right, 2, noise);
  }
  return match_tiles(normalize_locally(left), normalize_locally(right));
}

double mean_value(const Image& image) {
  double sum = 0;
  for (const float value : image.data) sum += value;
  return sum / static_cast<double>(image.data.size());
}

TEST(Normalize, EqualsTheDefinition) {
  Image view = textured(Texture(1, 0.4), 23, 14, 0);
  const Image normalized = normalize_locally(view);
  for (const auto& [x, y] : {std::pair{0, 0}, {11, 7}, {22, 13}, {3, 10}}) {
    double sum = 0, squares = 0, count = 0;
    for (int v = std::max(y - 4, 0); v <= std::min(y + 4, 13); ++v) {
      for (int u = std::max(x - 4, 0); u <= std::min(x + 4, 22); ++u) {
        sum += view.at(u, v);
        squares += static_cast<double>(view.at(u, v)) * view.at(u, v);
        count += 1;
      }
    }
    const double mean = sum / count, deviation = std::sqrt(squares / count - mean * mean);
    EXPECT_NEAR(normalized.at(x, y), (view.at(x, y) - mean) / (deviation + 0.001), 1e-5);
  }
}

TEST(Normalize, TakesOutGainAndOffset) {
  Image view = textured(Texture(1, 0.4), 40, 20, 0), shaded = view;
  for (float& value : shaded.data) value = 0.5f * value + 0.1f;
  const Image a = normalize_locally(view), b = normalize_locally(shaded);
  // The floor weighs twice as much at half the contrast: 0.001 / 0.03 (the least local deviation here) of 3.
  for (std::size_t i = 0; i < a.data.size(); ++i) EXPECT_NEAR(a.data[i], b.data[i], 0.1);
}

TEST(Normalize, FlatAndBrokenInputsStayFinite) {
  for (const float value : normalize_locally(Image(20, 20, 1, 0.3f)).data) EXPECT_NEAR(value, 0, 1e-4);
  Image broken = textured(Texture(1, 0.4), 20, 20, 0);
  broken.at(5, 5) = std::numeric_limits<float>::quiet_NaN();
  broken.at(6, 5) = std::numeric_limits<float>::infinity();
  for (const float value : normalize_locally(broken).data) EXPECT_TRUE(std::isfinite(value));
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 500}}) {
    for (const float value : normalize_locally(Image(width, height, 1, 0.5f)).data) EXPECT_TRUE(std::isfinite(value));
  }
}

/// Where the parabola through the least cost and its neighbors has its minimum, when every tile has the costs that
/// the texture has on average: twice its variance minus its correlation.
double locked(const Texture& texture, double d) {
  const double nearest = std::round(d);
  const auto cost = [&](double shift) { return 1 - texture.correlation(shift - d); };
  const double before = cost(nearest - 1), at = cost(nearest), after = cost(nearest + 1);
  return nearest + 0.5 * (before - after) / (before - 2 * at + after);
}

TEST(Match, FindsShiftsUpToTheKnownLockingOfAParabola) {
  // The costs of a texture are no parabola; reading one through them locks to whole pixels.
  for (const auto& [highest, most] : {std::pair{0.5, 0.1}, {0.25, 0.03}}) {
    const Texture texture(5, highest);
    const Image left = textured(texture, kTextureWidth, kTextureHeight, 0, 0, 1);
    for (double d = -2.375; d <= 2.4; d += 0.25) {
      const Image right = textured(texture, kTextureWidth, kTextureHeight, d, 0, 1);
      const double measured = mean_value(match_tiles(left, right).disparity_dp_px);
      EXPECT_NEAR(measured, locked(texture, d), 0.02) << d;  // tiles differ from the average texture
      EXPECT_NEAR(measured, d, most) << d;
    }
  }
}

TEST(Match, SignIsThatOfTheRightViewsShift) {
  const Texture texture(9, 0.3);
  const Image left = normalize_locally(textured(texture, kTextureWidth, kTextureHeight, 0));
  const Image right = normalize_locally(textured(texture, kTextureWidth, kTextureHeight, 1.0));
  EXPECT_NEAR(mean_value(match_tiles(left, right).disparity_dp_px), 1, 0.05);
  EXPECT_NEAR(mean_value(match_tiles(right, left).disparity_dp_px), -1, 0.05);  // swapped views
}

TEST(Match, ConfidenceIsHighOnTextureAndFallsWithNoise) {
  const double clean = mean_value(match_shifted(0.4, 0.25).confidence);
  const double noisy = mean_value(match_shifted(0.4, 0.25, 0.035).confidence);   // half the texture's deviation
  const double drowned = mean_value(match_shifted(0.4, 0.25, 0.14).confidence);  // twice
  EXPECT_GT(clean, 0.8);
  EXPECT_LT(noisy, 0.8 * clean);
  EXPECT_LT(drowned, 0.05);
}

TEST(Match, FlatTilesHaveNoConfidence) {
  const Image flat(kTextureWidth, kTextureHeight, 1, 0.3f);
  const TileDisparity tiles = match_tiles(normalize_locally(flat), normalize_locally(flat));
  for (const float confidence : tiles.confidence.data) EXPECT_EQ(confidence, 0);
  for (const float d : tiles.disparity_dp_px.data) EXPECT_EQ(d, 0);
  EXPECT_LT(mean_value(match_shifted(0.4, 0.25, 0.01, 0).confidence), 0.05);  // noise alone
}

TEST(Match, DisparityBeyondTheRangeHasLowConfidence) {
  for (const double d : {3.6, -3.6, 4.5, 6.0}) {
    EXPECT_LT(mean_value(match_shifted(d, 0.25).confidence), 0.1) << d;
  }
}

TEST(Match, LeastCostAtTheEndOfTheRangeIsNoMinimum) {
  Image left(kTextureWidth, kTextureHeight),
      right(kTextureWidth, kTextureHeight);  // the cost of shift s is (s - 3.8)^2 in every tile
  for (int y = 0; y < kTextureHeight; ++y) {
    for (int x = 0; x < kTextureWidth; ++x) {
      left.at(x, y) = static_cast<float>(x);
      right.at(x, y) = static_cast<float>(x) - 3.8f;
    }
  }
  const TileDisparity tiles = match_tiles(left, right);
  for (const float d : tiles.disparity_dp_px.data) EXPECT_EQ(d, 3);
  for (const float confidence : tiles.confidence.data) EXPECT_EQ(confidence, 0);
}

TEST(Match, VerticalContrastAloneHasLowConfidence) {
  Image rows(kTextureWidth, kTextureHeight);  // the aperture problem: nothing changes along x
  for (int y = 0; y < kTextureHeight; ++y) std::fill_n(rows.row(y), kTextureWidth, y % 5 < 2 ? 0.3f : 0.6f);
  Image other = rows;
  add_white_noise(rows, 1, 0.002);
  add_white_noise(other, 2, 0.002);
  EXPECT_LT(mean_value(match_tiles(normalize_locally(rows), normalize_locally(other)).confidence), 0.05);
}

TEST(Match, ATileUnlikeItsNeighborsLosesConfidence) {
  const Texture texture(9, 0.25);
  const Image left = textured(texture, kTextureWidth, kTextureHeight, 0, 0, 1);
  Image right = left;
  const Image moved = textured(texture, kTextureWidth, kTextureHeight, 1.5, 0, 1);
  for (int y = 24; y < 32; ++y) std::copy_n(moved.row(y) + 101, 14, right.row(y) + 101);  // tile (13, 3) and its range
  const TileDisparity tiles = match_tiles(left, right);
  EXPECT_LT(tiles.confidence.at(13, 3), 0.1f);
  EXPECT_GT(tiles.confidence.at(20, 3), 0.5f);
}

TEST(Match, ShiftsThatFitPerfectlyTwiceHaveLowConfidence) {
  Image columns(kTextureWidth, kTextureHeight);  // period 2: every other shift costs nothing at all
  for (int y = 0; y < kTextureHeight; ++y) {
    for (int x = 0; x < kTextureWidth; x += 2) columns.at(x, y) = 1;
  }
  for (const float confidence : match_tiles(columns, columns).confidence.data) EXPECT_EQ(confidence, 0);
}

TEST(Match, SmallAndBrokenInputsAreFiniteAndWithinRange) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 500}, {9, 9}, {13, 1}}) {
    const Texture texture(3, 0.3);
    Image left = textured(texture, width, height, 0);
    left.data.back() = std::numeric_limits<float>::quiet_NaN();
    const TileDisparity tiles = match_tiles(left, textured(texture, width, height, 1));
    EXPECT_EQ(tiles.disparity_dp_px.width, (width + 7) / 8);
    for (const float d : tiles.disparity_dp_px.data) EXPECT_LE(std::abs(d), 3);
    for (const float confidence : tiles.confidence.data) EXPECT_TRUE(confidence >= 0 && confidence <= 1);
    const PixelDisparity pixels = upsample_tiles(tiles, width, height);
    for (const float d : pixels.disparity_dp_px.data) EXPECT_LE(std::abs(d), 3);
    for (const float confidence : pixels.confidence.data) EXPECT_TRUE(confidence >= 0 && confidence <= 1);
  }
}

TEST(Upsample, UnconfidentTilesGiveWayAndEdgesLoseConfidence) {
  TileDisparity tiles{Image(4, 1, 1, 1.0f), Image(4, 1, 1, 1.0f)};
  tiles.disparity_dp_px.at(1, 0) = -3;
  tiles.confidence.at(1, 0) = 0;
  const PixelDisparity blended = upsample_tiles(tiles, 32, 8);
  for (const float d : blended.disparity_dp_px.data) EXPECT_TRUE(d == -3 || std::abs(d - 1) < 1e-5);
  EXPECT_NEAR(blended.disparity_dp_px.at(9, 4), 1, 1e-5);  // inside the tile without confidence
  EXPECT_LT(blended.confidence.at(11, 4), 0.1f);

  tiles.confidence.at(1, 0) = 1;  // now an edge of 4 px between confident tiles
  const PixelDisparity edge = upsample_tiles(tiles, 32, 8);
  EXPECT_LT(edge.confidence.at(7, 4), 1e-3f);
  EXPECT_NEAR(edge.confidence.at(3, 4), 1, 1e-6f);
}

TEST(Upsample, IsLinearBetweenEquallySureTiles) {
  TileDisparity tiles{Image(5, 1), Image(5, 1, 1, 1.0f)};
  for (int i = 0; i < 5; ++i) tiles.disparity_dp_px.at(i, 0) = 0.1f * static_cast<float>(i);
  const PixelDisparity pixels = upsample_tiles(tiles, 40, 8);
  for (int x = 4; x < 36; ++x) {
    EXPECT_NEAR(pixels.disparity_dp_px.at(x, 3), 0.1 * ((x + 0.5) / 8 - 0.5), 1e-5);
  }
}

TEST(Upsample, SigmaIsThatOfTheBlend) {
  // Four tiles that err by 0.1 each, independently or alike; then two that disagree by far more.
  TileDisparity tiles{Image(2, 2, 1, 0.5f), Image(2, 2, 1, 1.0f), Image(2, 2, 1, 0.1f), Image(2, 2)};
  const PixelDisparity independent = upsample_tiles(tiles, 16, 16);
  EXPECT_NEAR(independent.sigma_dp_px.at(0, 0), 0.1, 1e-6);  // one tile alone
  // 9/16 and 7/16 of two tiles along each axis
  EXPECT_NEAR(independent.sigma_dp_px.at(7, 7), 0.1 * (81 + 49) / 256, 1e-5);
  tiles.shared = Image(2, 2, 1, 1.0f);
  EXPECT_NEAR(upsample_tiles(tiles, 16, 16).sigma_dp_px.at(7, 7), 0.1, 1e-5);
  tiles.disparity_dp_px.at(1, 0) = tiles.disparity_dp_px.at(1, 1) = 2.5f;
  const double spread = 2 * std::sqrt(9.0 / 16 * 7 / 16);
  EXPECT_NEAR(upsample_tiles(tiles, 16, 16).sigma_dp_px.at(7, 7), std::hypot(spread, 0.1), 1e-4);
  tiles.confidence = Image(2, 2);  // no confidence anywhere: the plain blend of variances
  EXPECT_NEAR(upsample_tiles(tiles, 16, 16).sigma_dp_px.at(7, 7), 0.1, 1e-5);
  tiles.sigma_dp_px = tiles.shared = {};
  EXPECT_TRUE(upsample_tiles(tiles, 16, 16).sigma_dp_px.empty());
}

TEST(MergeMask, FaceIsWeightedByConfidenceAndTheInteriorFlattened) {
  PixelDisparity map{Image(8, 4, 1, 2.0f), Image(8, 4, 1, 0.25f)};
  map.disparity_dp_px.at(2, 1) = 1;
  map.disparity_dp_px.at(3, 1) = -2;
  map.confidence.at(2, 1) = 0.75f;
  EXPECT_NEAR(face_disparity(map, {2, 1, 2, 1}), (0.75 * 1 + 0.25 * -2) / 1, 1e-6);
  EXPECT_EQ(face_disparity(map, {20, 1, 2, 1}), 0);  // outside the picture

  Image mask(8, 4, 1, 0.94f);  // not above the threshold
  mask.at(2, 1) = 0.95f;
  EXPECT_EQ(interior_disparity(map, mask), 1);
  EXPECT_EQ(interior_disparity(map, Image(8, 4)), 0);
  const PixelDisparity flat = flatten_person(map, mask, 0.5f);
  EXPECT_EQ(flat.disparity_dp_px.at(2, 1), 0.5f);
  EXPECT_EQ(flat.confidence.at(2, 1), 1);
  EXPECT_EQ(flat.disparity_dp_px.at(3, 1), -2);
  EXPECT_EQ(flat.confidence.at(3, 1), 0.25f);
}

}  // namespace
}  // namespace dualpixel::pipeline
