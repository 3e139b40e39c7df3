#include "pipeline/disparity/paper/match.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::pipeline {
namespace {

struct Match {
  float disparity = 0;
  float confidence = 0;
};

float squared(float value) { return value * value; }

/// Pixels [x0, x1) x [y0, y1) of the left view against the right view; all shifts stay inside.
Match match_tile(const Image& left, const Image& right, int x0, int x1, int y0, int y1, const MatchOptions& options,
                 std::vector<float>& cost) {
  const int range = options.range_px;
  const float pixels = static_cast<float>((x1 - x0) * (y1 - y0));
  float gradient_square = 0;
  std::fill(cost.begin(), cost.end(), 0.0f);
  for (int y = y0; y < y1; ++y) {
    const float* l = left.row(y);
    const float* r = right.row(y);
    for (int shift = -range; shift <= range; ++shift) {
      float sum = 0;
      for (int x = x0; x < x1; ++x) sum += squared(l[x] - r[x + shift]);
      cost[shift + range] += sum / pixels;
    }
    for (int x = x0; x < x1; ++x) {
      gradient_square += squared(l[std::min(x + 1, left.width - 1)] - l[std::max(x - 1, 0)]) / (4 * pixels);
    }
  }

  // Among equal costs the smallest shift wins.
  int best = 0;
  for (int shift = 1; shift <= range; ++shift) {
    for (const int signed_shift : {-shift, shift}) {
      if (cost[signed_shift + range] < cost[best + range]) best = signed_shift;
    }
  }
  Match match{static_cast<float>(best), 0};
  if (std::abs(best) == range) return match;

  const float before = cost[best + range - 1];
  const float at = cost[best + range];
  const float after = cost[best + range + 1];
  const float curvature = before - 2 * at + after;
  if (!(curvature > 1e-6f) || !(before > at && after >= at)) return match;  // also where a cost is not a number
  const float offset = 0.5f * (before - after) / curvature;
  match.disparity = best + offset;

  const float least = std::max(at - 0.125f * squared(before - after) / curvature, 0.0f);
  float second = INFINITY;
  for (int shift = -range; shift <= range; ++shift) {
    if (std::abs(shift - best) > 1) second = std::min(second, cost[shift + range]);
  }
  const float texture = std::max(gradient_square - 0.25f * least, 0.0f);
  const float variance = (least + options.ssd_floor) / (pixels * texture);  // infinite without texture
  // where a second shift has no cost either, the best one is not distinct
  const float distinct =
      second > 0 ? std::clamp((1 - least / second) / (1 - options.second_minimum), 0.0f, 1.0f) : 0.0f;
  match.confidence =
      std::exp(-least / options.ssd_scale) / (1 + variance / squared(options.deviation_dp_px)) * squared(distinct);
  return match;
}

/// Share of the confidence of the eight tiles around (x, y) that agrees with its disparity; 1 where they have none.
float agreement(const TileDisparity& tiles, int x, int y, const MatchOptions& options) {
  const Image& disparity = tiles.disparity_dp_px;
  float supported = 1e-3f, total = 1e-3f;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, disparity.height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, disparity.width - 1); ++u) {
      if (u == x && v == y) continue;
      const float weight = tiles.confidence.at(u, v);
      const float difference = disparity.at(u, v) - disparity.at(x, y);
      supported += weight * std::exp(-squared(difference / options.agreement_dp_px));
      total += weight;
    }
  }
  return supported / total;
}

}  // namespace

OptionFields fields(MatchOptions& options) {
  return {{"tile_px", &options.tile_px, 1, 64, "DP px", "4.1: 8"},
          {"range_px", &options.range_px, 1, 64, "DP px", "4.1: 3"},
          {"ssd_scale", &options.ssd_scale, 1e-6, 1e6, "", "ours"},
          {"ssd_floor", &options.ssd_floor, 0, 1e6, "", "ours"},
          {"deviation_dp_px", &options.deviation_dp_px, 1e-6, 1e6, "DP px", "ours"},
          {"second_minimum", &options.second_minimum, 0, 0.999, "", "ours"},
          {"agreement_dp_px", &options.agreement_dp_px, 1e-6, 1e6, "DP px", "ours"}};
}

void check(const MatchOptions& options) { check_options("match", options); }

TileDisparity match_tiles(const Image& left, const Image& right, const MatchOptions& options) {
  require_views(left, right);
  check(options);
  const int tile = options.tile_px;
  const int range = options.range_px;
  const int columns = (left.width + tile - 1) / tile;
  const int rows = (left.height + tile - 1) / tile;
  TileDisparity tiles{.disparity_dp_px = Image(columns, rows), .confidence = Image(columns, rows), .tile_px = tile};
  for_rows(rows, [&](int row) {
    std::vector<float> cost(2 * range + 1);
    const int y0 = row * tile;
    const int y1 = std::min(y0 + tile, left.height);
    for (int column = 0; column < columns; ++column) {
      const int x0 = std::max(column * tile, range);
      const int x1 = std::min(column * tile + tile, left.width - range);
      if (x0 >= x1) continue;
      const Match match = match_tile(left, right, x0, x1, y0, y1, options, cost);
      tiles.disparity_dp_px.at(column, row) = match.disparity;
      tiles.confidence.at(column, row) = match.confidence;
    }
  });
  Image confidence = tiles.confidence;
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      confidence.at(column, row) *= agreement(tiles, column, row, options);
    }
  });
  tiles.confidence = std::move(confidence);
  return tiles;
}

}  // namespace dualpixel::pipeline
