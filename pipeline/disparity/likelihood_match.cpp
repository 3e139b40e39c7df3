#include "pipeline/disparity/likelihood_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "pipeline/disparity/interpolate.h"
#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kTile = 8;
constexpr float kBlind = 1e12f;           // variance of a pixel that says nothing
constexpr float kLeastVariance = 1e-12f;  // of shot noise in the dark
constexpr int kSpoiled = 2;               // pixels beside a blind one that interpolation would mix it into

using Columns = std::array<float, kTile>;  // one entry for each column of a tile: what the compiler makes vectors of

float square(float value) { return value * value; }

float sum(const Columns& lanes) {
  std::array<float, kTile / 2> half;
  for (int i = 0; i < kTile / 2; ++i) half[i] = lanes[i] + lanes[i + kTile / 2];
  return (half[0] + half[2]) + (half[1] + half[3]);
}

/// Of the difference of two pixels of these variances; 0 where either is blind.
float weight(float left_variance, float right_variance) {
  const float variance = left_variance + right_variance;
  return variance < kBlind ? 1 / variance : 0.0f;
}

/// One view, with `margin` pixels on both sides of each row, and rows up to whole tiles: no shift leaves it.
struct Padded {
  int margin = 0;
  Image signal;    // gain taken out; what is not finite is replaced by its left neighbour
  Image smooth;    // signal under 1/4 1/2 1/4 along x and y
  Image variance;  // of signal's noise; kBlind in the margin and where the pixel cannot be used
};

/// Mean over the (2 reach + 1)^2 pixels around each, as many as there are.
Image box_mean(const Image& image, int reach) {
  Image across(image.width, image.height), out(image.width, image.height);
  const auto mean = [reach](int size, int at, const auto& value) {
    const int first = std::max(at - reach, 0), last = std::min(at + reach, size - 1);
    double total = 0;
    for (int i = first; i <= last; ++i) total += value(i);
    return static_cast<float>(total / (last - first + 1));
  };
  for_rows(image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      across.at(x, y) = mean(image.width, x, [&](int i) { return image.at(i, y); });
    }
  });
  for_rows(image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      out.at(x, y) = mean(image.height, y, [&](int i) { return across.at(x, i); });
    }
  });
  return out;
}

bool usable(float value, float clipped) { return std::isfinite(value) && value < clipped; }

/// Sums over each tile's pixels that are usable in both views.
std::array<Image, 2> tile_sums(const Image& left, const Image& right, float clipped) {
  const int columns = (left.width + kTile - 1) / kTile, rows = (left.height + kTile - 1) / kTile;
  std::array<Image, 2> sums{Image(columns, rows), Image(columns, rows)};
  for_rows(rows, [&](int row) {
    for (int y = row * kTile; y < std::min((row + 1) * kTile, left.height); ++y) {
      for (int x = 0; x < left.width; ++x) {
        const float l = left.row(y)[x], r = right.row(y)[x];
        if (!usable(l, clipped) || !usable(r, clipped)) continue;
        sums[0].at(x / kTile, row) += l;
        sums[1].at(x / kTile, row) += r;
      }
    }
  });
  return sums;
}

/// Root of the local ratio right / left, one pixel a tile. Disparity moves light across a window's border only, so
/// wide windows see the shading alone.
Image shading_gain(const Image& left, const Image& right, float clipped) {
  auto [l, r] = tile_sums(left, right, clipped);
  const int reach = std::max(l.width / 20, 1);
  l = box_mean(box_mean(l, reach), reach);
  r = box_mean(box_mean(r, reach), reach);
  for (std::size_t i = 0; i < l.data.size(); ++i) {
    const float ratio = r.data[i] / l.data[i];
    l.data[i] = ratio > 0.0625f && ratio < 16 ? std::sqrt(ratio) : 1.0f;  // beyond that, or 0 / 0, no shading
  }
  return l;
}

/// `gain` holds one pixel a tile; the view is multiplied by it.
Padded prepare(const Image& view, const Image& gain, int margin, const ViewNoise& noise, float clipped) {
  const int stride = gain.width * kTile + 2 * margin;
  const int rows = gain.height * kTile;
  Padded out{margin, Image(stride, rows), Image(stride, rows), Image(stride, rows, 1, kBlind)};
  const Image across = resize_bilinear(gain, gain.width * kTile, gain.height);
  for_rows(rows, [&](int y) {
    const float* in = view.row(std::min(y, view.height - 1));
    float* signal = out.signal.row(y) + margin;
    bool finite = true;
    for (int x = 0; x < view.width; ++x) {
      finite &= std::isfinite(in[x]);
      signal[x] = std::clamp(in[x], -clipped, 2 * clipped);
    }
    if (!finite) {
      for (int x = 0; x < view.width; ++x) {
        if (!std::isfinite(in[x])) signal[x] = x > 0 ? signal[x - 1] : 0.0f;
      }
    }
    const LinearTap line = linear_tap(y, rows, gain.height);
    const float* low = across.row(line.low);
    const float* high = across.row(line.high);
    for (int x = 0; x < view.width; ++x) signal[x] *= low[x] + line.weight_of_high * (high[x] - low[x]);
    std::fill_n(out.signal.row(y), margin, signal[0]);
    std::fill(signal + view.width, out.signal.row(y) + stride, signal[view.width - 1]);
  });
  for_rows(rows, [&](int y) {
    const float* above = out.signal.row(std::max(y - 1, 0));
    const float* at = out.signal.row(y);
    const float* below = out.signal.row(std::min(y + 1, rows - 1));
    float* smooth = out.smooth.row(y);
    const auto down = [&](int x) { return 0.25f * (above[x] + below[x]) + 0.5f * at[x]; };
    smooth[0] = down(0);
    smooth[stride - 1] = down(stride - 1);
    for (int x = 1; x + 1 < stride; ++x) {
      smooth[x] = 0.25f * (down(x - 1) + down(x + 1)) + 0.5f * down(x);
    }
    if (y >= view.height) return;
    const float* in = view.row(y);
    const float* factor = across.row(y / kTile);
    float* variance = out.variance.row(y);
    bool all_usable = true;
    for (int x = kSpoiled; x < view.width - kSpoiled; ++x) {
      variance[margin + x] =
          factor[x] * (noise.shot * std::max(smooth[margin + x], 0.0f) + factor[x] * noise.read) + kLeastVariance;
    }
    for (int x = 0; x < view.width; ++x) all_usable &= usable(in[x], clipped);
    if (all_usable) return;
    for (int x = 0; x < view.width; ++x) {
      if (!usable(in[x], clipped)) std::fill_n(variance + margin + x - kSpoiled, 2 * kSpoiled + 1, kBlind);
    }
  });
  return out;
}

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

/// The left view is read `left_shift(s)` to the left, the right view s - left_shift(s) to the right.
int left_shift(int shift) { return shift >> 1; }

/// Turns costs into multiples of what noise and an imperfect model do to them, best shift 0.
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

void tile_costs(const Padded& left, const Padded& right, int width, int column, int row,
                const LikelihoodMatchOptions& options, float* cost) {
  const int range = options.range_px;
  const int x0 = column * kTile;
  // Every other row of the smoothed views holds nearly all of what they say: half the sum, counted twice.
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
  if (!(precision > 0)) {  // all pixels are blind
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

/// Each tile's costs plus what its four neighbours `distance` away say about them: their own costs, softened by one
/// pixel and capped, since a neighbour may lie on another surface.
CostVolume with_neighbours(const CostVolume& costs, int distance, float weight) {
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

struct Found {
  int shift = 0;
  float ambiguity = 0;  // variance of the shifts that are likely and not next to it, DP px^2
  bool at_end = false;
};

Found find_shift(const float* cost, int range) {
  // Among equal costs the smallest shift wins.
  int best = 0;
  for (int shift = 1; shift <= range; ++shift) {
    for (const int signed_shift : {-shift, shift}) {
      if (cost[signed_shift + range] < cost[best + range]) best = signed_shift;
    }
  }
  float total = 0, spread = 0;
  for (int shift = -range; shift <= range; ++shift) {
    const float likely = std::exp(-0.5f * cost[shift + range]);
    total += likely;
    if (std::abs(shift - best) > 1) spread += likely * square(static_cast<float>(shift - best));
  }
  return {best, spread / total, std::abs(best) == range};
}

/// Sums over a tile, each pixel weighed by one over the variance of the difference: r the difference right - left, b
/// the slope of the smoothed views, e the excess over it of the unsmoothed views' slope; both are means of the views.
struct TileSums {
  float one = 0, r = 0, b = 0, e = 0, rr = 0, br = 0, er = 0, bb = 0, be = 0, ee = 0;
  float left_noise = 0, right_noise = 0;  // the views' variances, as weighed
};

TileSums sample_tile(const Padded& left, const Padded& right, int x0, int y0, float disparity, float offset,
                     SincTaps& left_taps, SincTaps& right_taps) {
  const float at_left = -0.5f * disparity, at_right = 0.5f * disparity;
  const int left_whole = static_cast<int>(std::floor(at_left)), right_whole = static_cast<int>(std::floor(at_right));
  left_taps = sinc_taps(at_left - static_cast<float>(left_whole));
  right_taps = sinc_taps(at_right - static_cast<float>(right_whole));
  // Variances are those of the nearest pixel.
  const int left_near = static_cast<int>(std::lround(at_left)), right_near = static_cast<int>(std::lround(at_right));

  Columns one{}, r{}, b{}, e{}, rr{}, br{}, er{}, bb{}, be{}, ee{}, left_noise{}, right_noise{};
  for (int y = y0; y < y0 + kTile; ++y) {
    const float* l = left.signal.row(y) + left.margin + x0 + left_whole - 3;
    const float* ls = left.smooth.row(y) + left.margin + x0 + left_whole - 3;
    const float* lv = left.variance.row(y) + left.margin + x0 + left_near;
    const float* q = right.signal.row(y) + right.margin + x0 + right_whole - 3;
    const float* qs = right.smooth.row(y) + right.margin + x0 + right_whole - 3;
    const float* qv = right.variance.row(y) + right.margin + x0 + right_near;
    Columns difference{}, slope{}, smooth{};
    for (int k = 0; k < 8; ++k) {
      for (int i = 0; i < kTile; ++i) {
        difference[i] += right_taps.value[k] * q[i + k] - left_taps.value[k] * l[i + k];
        slope[i] += right_taps.slope[k] * q[i + k] + left_taps.slope[k] * l[i + k];
        smooth[i] += right_taps.slope[k] * qs[i + k] + left_taps.slope[k] * ls[i + k];
      }
    }
    for (int i = 0; i < kTile; ++i) {
      const float w = weight(lv[i], qv[i]);
      const float d = difference[i] - offset, s = 0.5f * smooth[i], x = 0.5f * (slope[i] - smooth[i]);
      one[i] += w;
      r[i] += w * d;
      b[i] += w * s;
      e[i] += w * x;
      rr[i] += w * d * d;
      br[i] += w * s * d;
      er[i] += w * x * d;
      bb[i] += w * s * s;
      be[i] += w * s * x;
      ee[i] += w * x * x;
      left_noise[i] += w * lv[i];
      right_noise[i] += w * qv[i];
    }
  }
  return {sum(one), sum(r),  sum(b),  sum(e),  sum(rr),         sum(br),
          sum(er),  sum(bb), sum(be), sum(ee), sum(left_noise), sum(right_noise)};
}

struct Refined {
  float disparity = 0;
  float noise = INFINITY;  // variance of the error that the views' noise makes: each tile's own
  float model = 0;         // and of that from what no shift explains: common to neighbours
};

Refined refine(const Padded& left, const Padded& right, int x0, int y0, float start, float offset, float offset_sigma,
               float farthest) {
  constexpr int kIterations = 4;
  constexpr float kSmallStep = 3e-3f;     // DP px; what would follow it is its square
  constexpr float kCorrelatedPixels = 3;  // noise is white; what the model gets wrong is alike over some pixels
  constexpr float kBlindError = 0.3f;     // of a tile with nearly all pixels blind, DP px
  Refined out{start};
  for (int iteration = 0;; ++iteration) {
    SincTaps lt, rt;
    const TileSums s = sample_tile(left, right, x0, y0, out.disparity, offset, lt, rt);
    const float pixels = s.left_noise + s.right_noise;  // each adds 1, blind ones nothing
    if (pixels < kTile) return {start};                 // nearly all are blind

    // The slope that the difference is held against: the smoothed views', plus as much of the excess as is signal.
    const float excess_noise = 0.25f * (s.left_noise * (lt.slope_slope - 2 * lt.slope_smooth + lt.smooth_smooth) +
                                        s.right_noise * (rt.slope_slope - 2 * rt.slope_smooth + rt.smooth_smooth));
    const float share = std::max(0.0f, 1 - excess_noise / s.ee);
    const auto with_share = [share](float smooth, float excess) { return smooth + share * excess; };
    const float D = with_share(s.b, s.e);     // sums of the slope held against ...
    const float Dr = with_share(s.br, s.er);  // ... and of its products
    const float Db = with_share(s.bb, s.be), De = with_share(s.be, s.ee);
    const float DD = with_share(Db, De);
    const float Da = Db + De;  // a = b + e, the unsmoothed slope
    const auto slope_D = [share](const SincTaps& t) {
      return t.slope_smooth + share * (t.slope_slope - t.slope_smooth);
    };
    // The offset between the views, normal with its standard deviation, marginalised.
    const float prior = 1 / square(offset_sigma);
    const float mean_D = D / (s.one + prior);
    const float gradient = Dr - mean_D * s.r;
    const float hessian =
        Da - mean_D * (s.b + s.e) - 0.25f * (s.right_noise * slope_D(rt) + s.left_noise * slope_D(lt));
    if (!(hessian > 0)) return {start};
    const float step = std::clamp(-gradient / hessian, -0.5f, 0.5f);
    out.disparity += step;
    if (std::abs(out.disparity - start) > farthest) return {start};
    if (iteration < kIterations && std::abs(step) > kSmallStep) continue;
    // Interpolation has taken noise out of the high frequencies, where the slope's excess lies.
    const float left_share = s.left_noise / pixels;
    const float passed = left_share * lt.value_value + (1 - left_share) * rt.value_value;
    const float noise_square = std::max(s.bb + passed * (DD - s.bb) - 2 * mean_D * D + square(mean_D) * s.one, 0.0f);
    out.noise = (noise_square + square(D - mean_D * s.one) / prior) / square(hessian);
    const float expected = pixels * passed - 2;
    const float residual = (s.rr - s.r * s.r / (s.one + prior) - square(gradient) / hessian) / expected;
    const float chance = std::sqrt(2 / expected);  // standard deviation of the residual under noise alone
    // Beside clipped light stands a highlight, often the mirror image of something at another depth.
    const float blind = 1 - pixels / (kTile * kTile);
    out.model = out.noise * kCorrelatedPixels * std::max(residual - 1 - chance, 0.0f) + square(kBlindError) * blind;
    return out;
  }
}

constexpr float kTilesPerPixel = 0.25f;  // standard deviation of pooling's weight in tiles, for a DP px of shift

/// Where blur is wider than a tile, the tiles around see much of the same light through other parts of the mirrored
/// kernels, and err differently: the mean over those that agree, by a weight that reaches as far as the shift is large.
Refined pooled(const std::vector<Refined>& tiles, int columns, int rows, int column, int row) {
  constexpr int kReach = 2;
  constexpr float kSameSurface = 0.15f;  // difference that still is the same surface, over the shift
  constexpr float kLeastSigma = 0.02f;   // of a tile, over the shift: no tile outweighs all others
  const Refined& tile = tiles[static_cast<std::size_t>(row) * columns + column];
  const float d = tile.disparity;
  const float spread = 2 * square(kTilesPerPixel * d);
  if (spread < 0.25f || !std::isfinite(tile.noise)) return tile;  // below 1.4 px the neighbours' weight vanishes
  float total = 0, shifts = 0, independent = 0, common = 0;
  for (int y = std::max(row - kReach, 0); y <= std::min(row + kReach, rows - 1); ++y) {
    for (int x = std::max(column - kReach, 0); x <= std::min(column + kReach, columns - 1); ++x) {
      const Refined& other = tiles[static_cast<std::size_t>(y) * columns + x];
      if (!std::isfinite(other.noise)) continue;
      const float variance = other.noise + other.model;
      const float away = square(static_cast<float>(x - column)) + square(static_cast<float>(y - row));
      const float differs =
          square(other.disparity - d) / (tile.noise + tile.model + variance + square(kSameSurface * d));
      const float weight = std::exp(-away / spread - 0.5f * differs) / (variance + square(kLeastSigma * d));
      total += weight;
      shifts += weight * other.disparity;
      independent += square(weight) * other.noise;
      common += weight * std::sqrt(other.model);
    }
  }
  return {shifts / total, independent / square(total), square(common / total)};
}

/// Correlation of two neighbouring tiles' noise after pooling: that of means under its weights, as far as they reach.
float pooled_share(float disparity) { return std::exp(-0.25f / square(kTilesPerPixel * disparity + 1e-6f)); }

/// Variance of the error as it is predicted: the tile's own, what mirrored kernels do to any, and what its neighbours
/// raise against it. A surface that is seen goes on in at least one half of the tiles around; a tile that stands alone
/// shows a highlight, a structure narrower than its blur, or a mistake, and may be as wrong as it is different.
float predicted_variance(const std::vector<Refined>& tiles, int columns, int rows, int column, int row) {
  // How far the matched shift of mirrored half discs lies from that of their centroids, which what they blur decides:
  // measured on textures of 0.02 to 0.4 cycles a pixel.
  constexpr float kKernelError = 0.02f;      // over the square of the shift, per DP px ...
  constexpr float kMostKernelError = 0.05f;  // ... and at most, DP px
  constexpr float kAgreement = 0.3f;         // difference on one surface, DP px, beside what both tiles' errors explain
  constexpr float kSupport = 0.625f;         // share of the neighbours that agree along a straight edge
  const Refined& tile = tiles[static_cast<std::size_t>(row) * columns + column];
  const float kernel = std::min(kKernelError * square(tile.disparity), kMostKernelError);
  const float own = tile.noise + tile.model + square(kernel);
  if (!std::isfinite(own)) return own;
  float count = 0, agree = 0, against = 0;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x) {
      const Refined& other = tiles[static_cast<std::size_t>(y) * columns + x];
      if ((x == column && y == row) || !std::isfinite(other.noise)) continue;
      const float squared = square(other.disparity - tile.disparity);
      const float agreement = std::exp(-0.5f * squared / (own + other.noise + other.model + square(kAgreement)));
      count += 1;
      agree += agreement;
      against += (1 - agreement) * squared;
    }
  }
  if (agree >= kSupport * count) return own;
  return own + (1 - agree / (kSupport * count)) * against / (count - agree);
}

}  // namespace

TileDisparity match_by_likelihood(const Image& left, const Image& right, const LikelihoodMatchOptions& options) {
  if (!left.same_size(right)) throw std::invalid_argument("disparity: left and right view differ in size");
  if (left.channels > 1 || right.channels > 1) throw std::invalid_argument("disparity: views must have one channel");
  if (options.range_px < 2 || options.range_px > 64) throw std::invalid_argument("disparity: range must be 2..64 px");
  if (left.empty()) return {};
  const ViewNoise noise = options.noise ? *options.noise : estimate_noise(left, right);
  if (!(noise.shot >= 0 && noise.read >= 0 && noise.shot + noise.read < INFINITY)) {
    throw std::invalid_argument("disparity: noise must be finite and not negative");
  }

  const int range = options.range_px;
  const int margin = range / 2 + 1 + 8;  // half the range, a step of refinement, the taps
  Image gain = shading_gain(left, right, options.clipped);
  const Padded l = prepare(left, gain, margin, noise, options.clipped);
  for (float& value : gain.data) value = 1 / value;
  const Padded r = prepare(right, gain, margin, noise, options.clipped);

  const int columns = gain.width, rows = gain.height;
  CostVolume costs{range, columns, rows,
                   std::vector<float>(static_cast<std::size_t>(columns) * rows * (2 * range + 1))};
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      tile_costs(l, r, left.width, column, row, options, costs.at(column, row));
      temper(costs.at(column, row), costs.shifts(), options.model_error);
    }
  });
  for (const int distance : {1, 2, 4}) costs = with_neighbours(costs, distance, options.neighbour_weight);

  // What is left of the shading: means of the views over 5 x 5 tiles, shifted to match.
  std::vector<Found> found(static_cast<std::size_t>(columns) * rows);
  Image difference(columns, rows), level(columns, rows);
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      Found& tile = found[static_cast<std::size_t>(row) * columns + column];
      tile = find_shift(costs.at(column, row), range);
      const int a = left_shift(tile.shift), b = tile.shift - a;
      Columns sums{}, levels{};
      for (int y = row * kTile; y < (row + 1) * kTile; ++y) {
        const float* ls = l.smooth.row(y) + margin + column * kTile - a;
        const float* rs = r.smooth.row(y) + margin + column * kTile + b;
        for (int i = 0; i < kTile; ++i) {
          sums[i] += rs[i] - ls[i];
          levels[i] += 0.5f * (rs[i] + ls[i]);
        }
      }
      difference.at(column, row) = sum(sums) / (kTile * kTile);
      level.at(column, row) = sum(levels) / (kTile * kTile);
    }
  });
  const Image local_difference = box_mean(difference, 2), local_level = box_mean(level, 2);

  const float limit = static_cast<float>(range);
  std::vector<Refined> refined(found.size());
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * columns + column;
      const Found& tile = found[i];
      const float signal = std::max(level.at(column, row), 1e-4f);
      const float offset = local_difference.at(column, row) / std::max(local_level.at(column, row), 1e-4f) * signal;
      refined[i] = refine(l, r, column * kTile, row * kTile, static_cast<float>(tile.shift), offset,
                          options.offset * signal, 1.5f);
      refined[i].disparity = std::clamp(refined[i].disparity, -limit, limit);
      refined[i].model += tile.ambiguity;
      if (tile.at_end) refined[i].noise = INFINITY;
    }
  });

  std::vector<Refined> smooth(refined.size());
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      smooth[static_cast<std::size_t>(row) * columns + column] = pooled(refined, columns, rows, column, row);
    }
  });
  TileDisparity tiles{Image(columns, rows), Image(columns, rows), Image(columns, rows), Image(columns, rows), kTile};
  for_rows(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const float variance = predicted_variance(smooth, columns, rows, column, row);
      const bool blind = !(variance < square(limit));
      const Refined& tile = smooth[static_cast<std::size_t>(row) * columns + column];
      tiles.disparity_dp_px.at(column, row) = tile.disparity;
      tiles.shared.at(column, row) = blind ? 1 : 1 - (1 - pooled_share(tile.disparity)) * tile.noise / variance;
      tiles.sigma_dp_px.at(column, row) = blind ? limit : std::sqrt(variance);
      tiles.confidence.at(column, row) = blind ? 0 : 1 / (1 + variance / square(options.confident_sigma_dp_px));
    }
  });
  return tiles;
}

}  // namespace dualpixel::pipeline
