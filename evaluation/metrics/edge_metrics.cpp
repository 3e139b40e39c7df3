#include "evaluation/metrics/edge_metrics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "evaluation/metrics/statistics.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kPlateauPx = 8, kSearchPx = 16;

/// Adds the widths at the edges of one row or column of `count` samples.
void add_widths(const float* estimate, const float* truth, std::ptrdiff_t step, int count, float jump,
                std::vector<double>& widths) {
  for (int x = kSearchPx; x + kSearchPx <= count; ++x) {
    const double low = truth[(x - 1) * step], high = truth[x * step], tolerance = 0.1 * std::abs(high - low);
    if (!(std::abs(high - low) > jump)) continue;
    bool flat = true;
    for (int k = 1; k < kPlateauPx; ++k) {
      flat &= std::abs(truth[(x - 1 - k) * step] - low) <= tolerance;
      flat &= std::abs(truth[(x + k) * step] - high) <= tolerance;
    }
    if (!flat) continue;
    const double from = estimate[(x - kSearchPx) * step], to = estimate[(x + kSearchPx - 1) * step];
    if ((to - from) / (high - low) < 0.25) {
      widths.push_back(2 * kSearchPx);
      continue;
    }
    // Where it last leaves 10 %, and first reaches 90 % thereafter.
    const auto along = [&](int k) { return (estimate[k * step] - from) / (to - from); };
    const auto crossing = [&](int k, double level) { return k + (level - along(k)) / (along(k + 1) - along(k)); };
    int end = x - kSearchPx;
    while (along(end + 1) < 0.9) ++end;
    int begin = end;
    while (along(begin) > 0.1) --begin;
    widths.push_back(crossing(end, 0.9) - crossing(begin, 0.1));
  }
}

Mask boundary(const Mask& mask) {
  Mask out(mask.width, mask.height);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      out.at(x, y) = mask.at(x, y) && ((x > 0 && !mask.at(x - 1, y)) || (x + 1 < mask.width && !mask.at(x + 1, y)) ||
                                       (y > 0 && !mask.at(x, y - 1)) || (y + 1 < mask.height && !mask.at(x, y + 1)));
    }
  }
  return out;
}

/// Share of `a`'s pixels with one of `b`'s at most reach_px away; 1 where `a` has none.
double share_near(const Mask& a, const Mask& b, int reach_px) {
  std::size_t count = 0, near = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      if (!a.at(x, y)) continue;
      ++count;
      bool found = false;
      for (int v = std::max(y - reach_px, 0); v <= std::min(y + reach_px, a.height - 1) && !found; ++v) {
        for (int u = std::max(x - reach_px, 0); u <= std::min(x + reach_px, a.width - 1) && !found; ++u) {
          found = b.at(u, v) && (u - x) * (u - x) + (v - y) * (v - y) <= reach_px * reach_px;
        }
      }
      near += found;
    }
  }
  return count > 0 ? static_cast<double>(near) / static_cast<double>(count) : 1;
}

}  // namespace

double edge_width_px(const Image& estimate, const Image& truth, float jump) {
  std::vector<double> widths;
  for (int y = 0; y < truth.height; ++y) add_widths(estimate.row(y), truth.row(y), 1, truth.width, jump, widths);
  for (int x = 0; x < truth.width; ++x) {
    add_widths(estimate.data.data() + x, truth.data.data() + x, truth.width, truth.height, jump, widths);
  }
  if (widths.empty()) return 0;
  return median(std::move(widths));
}

double boundary_f_score(const Mask& estimate, const Mask& truth, int reach_px) {
  const Mask a = boundary(estimate), b = boundary(truth);
  const double precision = share_near(a, b, reach_px), recall = share_near(b, a, reach_px);
  return precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0;
}

Mask thin_structures(const Image& map, float jump) {
  Mask thin(map.width, map.height);
  tbb::parallel_for(0, map.height, [&](int y) {
    std::array<float, 25> window;
    for (int x = 0; x < map.width; ++x) {
      for (int k = 0; k < 25; ++k) {
        window[k] = map.at(std::clamp(x + 2 * (k % 5) - 4, 0, map.width - 1),
                           std::clamp(y + 2 * (k / 5) - 4, 0, map.height - 1));
      }
      std::nth_element(window.begin(), window.begin() + 12, window.end());
      thin.at(x, y) = std::abs(map.at(x, y) - window[12]) > jump;
    }
  });
  return thin;
}

}  // namespace dualpixel::evaluation
