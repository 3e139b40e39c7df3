#include "evaluation/metrics/disparity_metrics.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace dualpixel::evaluation {
namespace {

constexpr double kRidge = 1e-5;
constexpr int kRobustRounds = 5;
constexpr double kSmallestResidual = 1e-3;
constexpr int kCurvePoints = 20;

double residual(const AffineFit& fit, float estimate, float truth) { return fit.scale * estimate + fit.offset - truth; }

/// Normal equations of fit_affine with weight(i) on pixel i.
template <typename Weight>
AffineFit fit_weighted(std::span<const float> estimate, std::span<const float> truth, const Weight& weight) {
  double w = 0, e = 0, ee = 0, t = 0, et = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const double wi = weight(i), ei = estimate[i], ti = truth[i];
    w += wi;
    e += wi * ei;
    ee += wi * ei * ei;
    t += wi * ti;
    et += wi * ei * ti;
  }
  w += kRidge;
  ee += kRidge;
  const double determinant = ee * w - e * e;
  return {(et * w - e * t) / determinant, (ee * t - e * et) / determinant};
}

/// A value's index in its array, and its bits mapped so that they order as an unsigned integer; equal values have equal
/// keys.
struct Keyed {
  std::uint32_t key;
  std::uint32_t index;
};

/// `values` from the smallest to the largest, equal ones in their order: a radix sort in three passes of 11 bits, since
/// millions of pixels are ranked for each region.
std::vector<Keyed> sorted(std::span<const float> values) {
  constexpr int kDigitBits = 11;
  constexpr std::uint32_t kDigits = 1u << kDigitBits;
  std::vector<Keyed> from(values.size()), to(values.size());
  for (std::uint32_t i = 0; i < values.size(); ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(values[i] + 0.0f);  // adding 0 turns -0 into 0
    from[i] = {bits & 0x80000000u ? ~bits : bits | 0x80000000u, i};
  }
  for (int shift = 0; shift < 32; shift += kDigitBits) {
    std::vector<std::uint32_t> next(kDigits + 1, 0);
    for (const Keyed& entry : from) ++next[(entry.key >> shift & (kDigits - 1)) + 1];
    for (std::uint32_t d = 0; d < kDigits; ++d) next[d + 1] += next[d];
    for (const Keyed& entry : from) to[next[entry.key >> shift & (kDigits - 1)]++] = entry;
    std::swap(from, to);
  }
  return from;
}

/// Calls tie(begin, end) for each run of equal values.
template <typename Tie>
void for_each_tie(const std::vector<Keyed>& order, const Tie& tie) {
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && order[end].key == order[begin].key) ++end;
    tie(begin, end);
  }
}

/// Mean error of the j pixels with the highest score, at [j - 1] for j = 1..n.
std::vector<double> mean_of_best(std::span<const float> error, std::span<const float> score) {
  std::vector<Keyed> order = sorted(score);
  std::reverse(order.begin(), order.end());
  std::vector<double> means(error.size());
  double sum = 0;
  for_each_tie(order, [&](std::size_t begin, std::size_t end) {
    double tied = 0;
    for (std::size_t i = begin; i < end; ++i) tied += error[order[i].index];
    const double each = tied / static_cast<double>(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      sum += each;
      means[i] = sum / static_cast<double>(i + 1);
    }
  });
  return means;
}

/// out(x) = any of in(x - reach .. x + reach), along a line of `count` values `stride` apart.
void dilate_line(const std::uint8_t* in, std::uint8_t* out, int count, std::size_t stride, int reach) {
  int last_set = -reach - 1;  // the furthest set pixel seen up to x + reach
  for (int ahead = 0; ahead < std::min(reach, count); ++ahead) {
    if (in[ahead * stride]) last_set = ahead;
  }
  for (int x = 0; x < count; ++x) {
    const int ahead = x + reach;
    if (ahead < count && in[ahead * stride]) last_set = ahead;
    out[x * stride] = last_set >= x - reach;
  }
}

}  // namespace

AffineFit fit_affine(std::span<const float> estimate, std::span<const float> truth) {
  return fit_weighted(estimate, truth, [](std::size_t) { return 1.0; });
}

double bias(std::span<const float> estimate, std::span<const float> truth) {
  double sum = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) sum += static_cast<double>(estimate[i]) - truth[i];
  return sum / static_cast<double>(estimate.size());
}

double rmse(std::span<const float> estimate, std::span<const float> truth, const AffineFit& fit) {
  double sum = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const double r = residual(fit, estimate[i], truth[i]);
    sum += r * r;
  }
  return std::sqrt(sum / static_cast<double>(estimate.size()));
}

double bad_pixel_rate(std::span<const float> estimate, std::span<const float> truth, double threshold,
                      const AffineFit& fit) {
  std::size_t bad = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) bad += std::abs(residual(fit, estimate[i], truth[i])) > threshold;
  return static_cast<double>(bad) / static_cast<double>(estimate.size());
}

double aiwe1(std::span<const float> estimate, std::span<const float> truth) {
  AffineFit fit = fit_affine(estimate, truth);
  for (int round = 1; round < kRobustRounds; ++round) {
    fit = fit_weighted(estimate, truth, [&](std::size_t i) {
      return 1 / std::max(kSmallestResidual, std::abs(residual(fit, estimate[i], truth[i])));
    });
  }
  double sum = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) sum += std::abs(residual(fit, estimate[i], truth[i]));
  return sum / static_cast<double>(estimate.size());
}

std::vector<double> average_ranks(std::span<const float> values) {
  const std::vector<Keyed> order = sorted(values);
  std::vector<double> ranks(values.size());
  for_each_tie(order, [&](std::size_t begin, std::size_t end) {
    const double rank = static_cast<double>(begin + end + 1) / 2;  // mean of begin + 1 ... end
    for (std::size_t i = begin; i < end; ++i) ranks[order[i].index] = rank;
  });
  return ranks;
}

std::optional<double> spearman(std::span<const float> a, std::span<const float> b) {
  const std::vector<double> rank_a = average_ranks(a), rank_b = average_ranks(b);
  const double mean = (static_cast<double>(a.size()) + 1) / 2;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double da = rank_a[i] - mean, db = rank_b[i] - mean;
    aa += da * da;
    bb += db * db;
    ab += da * db;
  }
  if (aa == 0 || bb == 0) return std::nullopt;
  return ab / std::sqrt(aa * bb);
}

Sparsification sparsification(std::span<const float> error, std::span<const float> confidence) {
  const std::size_t n = error.size();
  std::vector<float> accuracy(n);
  for (std::size_t i = 0; i < n; ++i) accuracy[i] = -error[i];
  const std::vector<double> by_confidence = mean_of_best(error, confidence);
  const std::vector<double> by_error = mean_of_best(error, accuracy);

  Sparsification curves;
  for (int point = 0; point < kCurvePoints && n > 0; ++point) {
    const std::size_t remaining = n - n * point / kCurvePoints;
    curves.removed.push_back(static_cast<double>(point) / kCurvePoints);
    curves.error.push_back(by_confidence[remaining - 1]);
    curves.oracle.push_back(by_error[remaining - 1]);
  }
  if (n == 0 || by_error.back() == 0) return curves;
  double area = 0;
  for (std::size_t i = 0; i < n; ++i) area += by_confidence[i] - by_error[i];
  curves.ause = area / static_cast<double>(n) / by_error.back();
  return curves;
}

Mask depth_edges(const Image& disparity_dp_px, float jump_dp_px, int reach_px) {
  const Image& d = disparity_dp_px;
  Mask borders(d.width, d.height);
  for (int y = 0; y < d.height; ++y) {
    for (int x = 0; x < d.width; ++x) {
      if (x > 0 && std::abs(d.at(x, y) - d.at(x - 1, y)) > jump_dp_px) borders.at(x, y) = borders.at(x - 1, y) = 1;
      if (y > 0 && std::abs(d.at(x, y) - d.at(x, y - 1)) > jump_dp_px) borders.at(x, y) = borders.at(x, y - 1) = 1;
    }
  }
  const int reach = reach_px - 1;
  Mask rows(d.width, d.height), edges(d.width, d.height);
  for (int y = 0; y < d.height; ++y) dilate_line(borders.row(y), rows.row(y), d.width, 1, reach);
  for (int x = 0; x < d.width; ++x) {
    dilate_line(rows.data.data() + x, edges.data.data() + x, d.height, static_cast<std::size_t>(d.width), reach);
  }
  return edges;
}

}  // namespace dualpixel::evaluation
