#include "pipeline/disparity/likelihood/shift_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/image/rows.h"

namespace dualpixel::pipeline::likelihood {
namespace {

/// Costs of all shifts of all tiles: minus twice the log-likelihood, but for a constant.
struct CostVolume {
  int range = 0;
  int columns = 0;
  int rows = 0;
  std::vector<float> data;

  int shifts() const { return 2 * range + 1; }
  float* at(int column, int row) { return data.data() + (static_cast<std::size_t>(row) * columns + column) * shifts(); }
  const float* at(int column, int row) const { return const_cast<CostVolume*>(this)->at(column, row); }
};

/// Scales costs down by what noise and model error add to them, and shifts them so that the best has cost 0.
void temper(float* cost, int shifts, float model_error) {
  constexpr float kExpected = kTile * kTile;  // least cost of a true match: one for each pixel
  constexpr float kExcess = 16;  // of the least cost over what is expected that halves all: ours, by the failure atlas
  float least = INFINITY, total = 0;
  for (int i = 0; i < shifts; ++i) {
    least = std::min(least, cost[i]);
    total += cost[i];
  }
  const float contrast = total / static_cast<float>(shifts) - least;
  const float scale = 1 / (1 + model_error * contrast + std::max(least - kExpected, 0.0f) / kExcess);
  for (int i = 0; i < shifts; ++i) cost[i] = (cost[i] - least) * scale;
}

void tile_costs(const PreparedView& left, const PreparedView& right, int width, int column, int row,
                const LikelihoodMatchOptions& options, float* cost) {
  const int range = options.range_px;
  const int x0 = column * kTile;
  // Every other row of the smoothed views holds nearly all of their information: half the sum, counted twice.
  constexpr int kRowStep = 2;
  float mean = 0, precision = 0;
  for (int y = row * kTile; y < (row + 1) * kTile; y += kRowStep) {
    const float* l = left.smooth.row(y) + left.margin + x0;
    const float* r = right.smooth.row(y) + right.margin + x0;
    const float* vl = left.variance.row(y) + left.margin + x0;
    const float* vr = right.variance.row(y) + right.margin + x0;
    Columns means, weights;
    for (int i = 0; i < kTile; ++i) {
      weights[i] = weight(vl[i], vr[i]);
      means[i] = weights[i] * 0.5f * (l[i] + r[i]);
    }
    mean += sum(means);
    precision += sum(weights);
  }
  if (!(precision > 0)) {  // all pixels are invalid
    std::fill_n(cost, 2 * range + 1, 0.0f);
    return;
  }
  mean /= precision;
  precision *= kRowStep / static_cast<float>(kTile * kTile);
  const float prior = 1 / (square(options.offset_search * mean) * precision + 1e-12f);

  float worst = 0;
  for (int shift = -range; shift <= range; ++shift) {
    const int a = left_shift(shift), b = shift - a;
    const int first = std::max({0, a - x0, -b - x0});
    const int last = std::min({kTile, width - x0 + std::min(a, 0), width - x0 - std::max(b, 0)});
    if (last - first < kTile / 2) {
      cost[shift + range] = -1;  // too little of it lies inside: filled in below
      continue;
    }
    Columns squares{}, sums{}, inside;
    for (int i = 0; i < kTile; ++i) inside[i] = i >= first && i < last ? 1.0f : 0.0f;
    for (int y = row * kTile; y < (row + 1) * kTile; y += kRowStep) {
      const float* l = left.smooth.row(y) + left.margin + x0 - a;
      const float* r = right.smooth.row(y) + right.margin + x0 + b;
      for (int i = 0; i < kTile; ++i) {
        const float difference = (r[i] - l[i]) * inside[i];
        sums[i] += difference;
        squares[i] += difference * difference;
      }
    }
    float& out = cost[shift + range];
    const float pixels = static_cast<float>((last - first) * kTile);
    const float total = kRowStep * sum(sums);
    out = (kRowStep * sum(squares) - total * total / (pixels + prior)) * precision * (kTile * kTile / pixels);
    worst = std::max(worst, out);
  }
  for (int i = 0; i <= 2 * range; ++i) {
    if (cost[i] < 0) cost[i] = worst;
  }
  // A whole shift may lie half a pixel from the true one: take the least cost within that distance, as Birchfield and
  // Tomasi (1998) do for intensities.
  float before = cost[0];
  for (int i = 1; i < 2 * range; ++i) {
    const float at = cost[i], after = cost[i + 1];
    const float curvature = before - 2 * at + after;
    if (at <= before && at <= after && curvature > 0) {
      cost[i] = std::max(at - 0.125f * square(before - after) / curvature, 0.0f);
    }
    before = at;
  }
}

/// Each tile's costs plus those of its four neighbors `distance` away: their own costs, softened by one
/// pixel and capped, since a neighbor may lie on another surface.
CostVolume with_neighbors(const CostVolume& costs, int distance, float weight) {
  constexpr float kSlope = 1;  // for each pixel of difference in shift
  constexpr float kCap = 10;
  const int shifts = costs.shifts();
  CostVolume out = costs;
  for_rows(costs.rows, [&](int row) {
    for (int column = 0; column < costs.columns; ++column) {
      float* cost = out.at(column, row);
      for (const auto& [dx, dy] : {std::pair{-distance, 0}, {distance, 0}, {0, -distance}, {0, distance}}) {
        const int u = column + dx, v = row + dy;
        if (u < 0 || u >= costs.columns || v < 0 || v >= costs.rows) continue;
        const float* message = costs.at(u, v);
        cost[0] += weight * std::min({message[0], message[1] + kSlope, kCap});
        for (int i = 1; i + 1 < shifts; ++i) {
          const float near = std::min(message[i - 1], message[i + 1]) + kSlope;
          cost[i] += weight * std::min(std::min(message[i], near), kCap);
        }
        cost[shifts - 1] += weight * std::min({message[shifts - 1], message[shifts - 2] + kSlope, kCap});
      }
      const float least = *std::min_element(cost, cost + shifts);
      for (int i = 0; i < shifts; ++i) cost[i] -= least;
    }
  });
  return out;
}

FoundShift find_shift(const float* cost, int range) {
  // A likelihood is exp(-cost / 2). Tempering the costs widens the predicted error: at 0.5, 73 % of the pixels of
  // scenes lie within one sigma. From 0.7 on, the matcher is overconfident at the failure atlas' strong defocus.
  constexpr float kInverseTemperature = 0.6f;
  constexpr float kUnlikely = 30;  // spares most of the exponentials
  // Among equal costs the smallest shift wins.
  int best = 0;
  for (int shift = 1; shift <= range; ++shift) {
    for (const int signed_shift : {-shift, shift}) {
      if (cost[signed_shift + range] < cost[best + range]) best = signed_shift;
    }
  }
  float total = 0, spread = 0;
  for (int shift = -range; shift <= range; ++shift) {
    if (cost[shift + range] > kUnlikely) continue;
    const float likely = std::exp(-kInverseTemperature * cost[shift + range]);
    total += likely;
    if (std::abs(shift - best) > 1) spread += likely * square(static_cast<float>(shift - best));
  }
  return {best, spread / total, std::abs(best) == range};
}

}  // namespace

std::vector<FoundShift> search_shifts(const PreparedViews& views, const LikelihoodMatchOptions& options) {
  const int range = options.range_px, columns = views.columns, rows = views.rows;
  CostVolume costs{range, columns, rows,
                   std::vector<float>(static_cast<std::size_t>(columns) * rows * (2 * range + 1))};
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      tile_costs(views.left, views.right, views.width, column, row, options, costs.at(column, row));
      temper(costs.at(column, row), costs.shifts(), options.model_error);
    }
  });
  for (const int distance : {1, 2, 4}) costs = with_neighbors(costs, distance, options.neighbor_weight);
  std::vector<FoundShift> found(static_cast<std::size_t>(columns) * rows);
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      found[static_cast<std::size_t>(row) * columns + column] = find_shift(costs.at(column, row), range);
    }
  });
  return found;
}

}  // namespace dualpixel::pipeline::likelihood
