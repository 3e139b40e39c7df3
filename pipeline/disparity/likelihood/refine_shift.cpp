#include "pipeline/disparity/likelihood/refine_shift.h"

#include <algorithm>

#include "pipeline/disparity/likelihood/interpolate.h"

namespace dualpixel::pipeline::likelihood {
namespace {

constexpr float kTilesPerPixel = 0.25f;  // standard deviation of pooling's weight in tiles, for a DP px of shift

/// Sums over a tile, each pixel weighed by one over the variance of the difference: r the difference right - left, less
/// what the kernels' skew makes of it; b the slope of the smoothed views, e the excess over it of the unsmoothed views'
/// slope, both means of the views; c what the skew term changes by with the disparity. In products with skew terms each
/// view's slope is multiplied by the other's, so that noise, which is not common to the views, adds nothing.
struct TileSums {
  float one = 0, r = 0, b = 0, e = 0, rr = 0, br = 0, er = 0, bb = 0, be = 0, ee = 0, bc = 0, ec = 0;
  float left_noise = 0, right_noise = 0;  // the views' variances, as weighed
};

/// What third moments add to a view: this much of its third derivative and of its slope's excess over the smoothed
/// view's. Smoothing by 1/4 1/2 1/4 along x and y adds a fourth of the second derivatives along both.
struct SkewTerm {
  float third = 0, excess = 0;

  explicit SkewTerm(const KernelSkew& skew) : third(skew.xxx / 6 - skew.xyy / 2), excess(-4 * skew.xyy / 2) {}
};

TileSums sample_tile(const PreparedView& left, const PreparedView& right, int x0, int y0, float disparity, float offset,
                     const SkewTerm& skew, const SkewTerm& change, SincTaps& left_taps, SincTaps& right_taps) {
  const float at_left = -0.5f * disparity, at_right = 0.5f * disparity;
  const int left_whole = static_cast<int>(std::floor(at_left)), right_whole = static_cast<int>(std::floor(at_right));
  left_taps = sinc_taps(at_left - static_cast<float>(left_whole));
  right_taps = sinc_taps(at_right - static_cast<float>(right_whole));
  // Variances are those of the nearest pixel.
  const int left_near = static_cast<int>(std::lround(at_left)), right_near = static_cast<int>(std::lround(at_right));

  Columns one{}, r{}, b{}, e{}, rr{}, br{}, er{}, bb{}, be{}, ee{}, bc{}, ec{}, left_noise{}, right_noise{};
  for (int y = y0; y < y0 + kTile; ++y) {
    const float* l = left.signal.row(y) + left.margin + x0 + left_whole - 3;
    const float* ls = left.smooth.row(y) + left.margin + x0 + left_whole - 3;
    const float* lv = left.variance.row(y) + left.margin + x0 + left_near;
    const float* q = right.signal.row(y) + right.margin + x0 + right_whole - 3;
    const float* qs = right.smooth.row(y) + right.margin + x0 + right_whole - 3;
    const float* qv = right.variance.row(y) + right.margin + x0 + right_near;
    Columns difference{}, left_slope{}, right_slope{}, left_smooth{}, right_smooth{}, left_third{}, right_third{};
    for (int k = 0; k < 8; ++k) {
      for (int i = 0; i < kTile; ++i) {
        difference[i] += right_taps.value[k] * q[i + k] - left_taps.value[k] * l[i + k];
        left_slope[i] += left_taps.slope[k] * l[i + k];
        right_slope[i] += right_taps.slope[k] * q[i + k];
        left_smooth[i] += left_taps.slope[k] * ls[i + k];
        right_smooth[i] += right_taps.slope[k] * qs[i + k];
        left_third[i] += left_taps.third[k] * l[i + k];
        right_third[i] += right_taps.third[k] * q[i + k];
      }
    }
    for (int i = 0; i < kTile; ++i) {
      const float w = weight(lv[i], qv[i]);
      const float left_excess = left_slope[i] - left_smooth[i], right_excess = right_slope[i] - right_smooth[i];
      const float left_skew = skew.third * left_third[i] + skew.excess * left_excess;
      const float right_skew = skew.third * right_third[i] + skew.excess * right_excess;
      const float left_change = change.third * left_third[i] + change.excess * left_excess;
      const float right_change = change.third * right_third[i] + change.excess * right_excess;
      const float seen = difference[i] - offset, d = seen + left_skew + right_skew;
      const float s = 0.5f * (left_smooth[i] + right_smooth[i]), x = 0.5f * (left_excess + right_excess);
      one[i] += w;
      r[i] += w * d;
      b[i] += w * s;
      e[i] += w * x;
      rr[i] += w * d * d;
      br[i] += w * (s * seen + left_smooth[i] * right_skew + right_smooth[i] * left_skew);
      er[i] += w * (x * seen + left_excess * right_skew + right_excess * left_skew);
      bb[i] += w * s * s;
      be[i] += w * s * x;
      ee[i] += w * x * x;
      bc[i] += w * (left_smooth[i] * right_change + right_smooth[i] * left_change);
      ec[i] += w * (left_excess * right_change + right_excess * left_change);
      left_noise[i] += w * lv[i];
      right_noise[i] += w * qv[i];
    }
  }
  return {sum(one), sum(r),  sum(b),  sum(e),  sum(rr), sum(br),         sum(er),
          sum(bb),  sum(be), sum(ee), sum(bc), sum(ec), sum(left_noise), sum(right_noise)};
}

/// Of a tile's pixels, those that both views show at this disparity, away from where their left and right border
/// invalidate interpolation.
int inside(const PreparedViews& views, int x0, int y0, float disparity) {
  const int edge = kInvalidMargin + static_cast<int>(std::lround(0.5f * std::abs(disparity)));
  const int columns = std::min(x0 + kTile, views.width - edge) - std::max(x0, edge);
  return std::max(columns, 1) * (std::min(y0 + kTile, views.height) - y0);
}

}  // namespace

RefinedTile refine_shift(const PreparedViews& views, int x0, int y0, float start, const ViewOffset& offset,
                         const SkewCurve& skew, float farthest) {
  constexpr int kIterations = 4;
  constexpr float kSmallStep = 0.02f;     // DP px; what would follow is below 0.02 sigma in 99 % of the tiles
  constexpr float kCorrelatedPixels = 3;  // noise is white; what the model gets wrong is alike over some pixels
  constexpr float kInvalidError = 0.3f;   // of a tile with nearly all pixels invalid, DP px
  RefinedTile out{start};
  for (int iteration = 0;; ++iteration) {
    SincTaps lt, rt;
    const SkewTerm skew_here(skew.at(out.disparity)), change(skew.slope_at(out.disparity));
    const TileSums s =
        sample_tile(views.left, views.right, x0, y0, out.disparity, offset.mean, skew_here, change, lt, rt);
    const float pixels = s.left_noise + s.right_noise;  // each adds 1, invalid ones nothing
    if (pixels < kTile) return {start};                 // nearly all are invalid

    // The slope that explains the difference: the smoothed views', plus that share of the excess which is signal.
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
    // The offset between the views, normal with its standard deviation, marginalized.
    const float prior = 1 / square(offset.sigma);
    const float mean_D = D / (s.one + prior);
    const float gradient = Dr - mean_D * s.r;
    const float hessian = Da - mean_D * (s.b + s.e) + with_share(s.bc, s.ec) -
                          0.25f * (s.right_noise * slope_D(rt) + s.left_noise * slope_D(lt));
    if (!(hessian > 0)) return {start};
    const float at = out.disparity, step = std::clamp(-gradient / hessian, -0.5f, 0.5f);
    out.disparity += step;
    if (std::abs(out.disparity - start) > farthest) return {start};
    if (iteration < kIterations && std::abs(step) > kSmallStep) continue;
    // Interpolation has taken noise out of the high frequencies, where the slope's excess lies.
    const float left_share = s.left_noise / pixels;
    const float passed = left_share * lt.value_value + (1 - left_share) * rt.value_value;
    const float noise_square = std::max(s.bb + passed * (DD - s.bb) - 2 * mean_D * D + square(mean_D) * s.one, 0.0f);
    out.noise = (noise_square + square(D - mean_D * s.one) / prior) / square(hessian);
    // What skew terms add to the noise is left in the residual, as a margin: where kernels are not what they are taken
    // for, a sigma without it was trusted in 2 to 9 % of pictures that were wrong.
    const float expected = pixels * passed - 2;
    const float residual = (s.rr - s.r * s.r / (s.one + prior) - square(gradient) / hessian) / expected;
    const float chance = std::sqrt(2 / expected);  // standard deviation of the residual under noise alone
    // Next to clipped light is a highlight, often the mirror image of something at another depth.
    const float invalid_share = std::max(1 - pixels / static_cast<float>(inside(views, x0, y0, at)), 0.0f);
    out.model = out.noise * kCorrelatedPixels * std::max(residual - 1 - 1.5f * chance, 0.0f) +
                square(kInvalidError) * invalid_share;
    return out;
  }
}

RefinedTile pooled_with_neighbors(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row) {
  constexpr int kReach = 2;
  constexpr float kSameSurface = 0.15f;  // difference that still is the same surface, over the shift
  constexpr float kLeastSigma = 0.02f;   // of a tile, over the shift: no tile outweighs all others
  const RefinedTile& tile = tiles[static_cast<std::size_t>(row) * columns + column];
  const float d = tile.disparity;
  const float spread = 2 * square(kTilesPerPixel * d);
  if (spread < 0.25f || !std::isfinite(tile.noise)) return tile;  // below 1.4 px the neighbors' weight vanishes
  float total = 0, shifts = 0, independent = 0, common = 0;
  for (int y = std::max(row - kReach, 0); y <= std::min(row + kReach, rows - 1); ++y) {
    for (int x = std::max(column - kReach, 0); x <= std::min(column + kReach, columns - 1); ++x) {
      const RefinedTile& other = tiles[static_cast<std::size_t>(y) * columns + x];
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

float pooled_share(float disparity) { return std::exp(-0.25f / square(kTilesPerPixel * disparity + 1e-6f)); }

float roughness(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row) {
  constexpr float kClearly = 3;
  const float here = tiles[static_cast<std::size_t>(row) * columns + column].disparity;
  float count = 0, total = 0, squares = 0, explained = 0;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x) {
      const RefinedTile& tile = tiles[static_cast<std::size_t>(y) * columns + x];
      if (!std::isfinite(tile.noise + tile.model)) continue;
      count += 1;
      total += tile.disparity - here;
      squares += square(tile.disparity - here);
      explained += tile.noise + tile.model;
    }
  }
  if (count < 2) return 0;
  explained /= count;
  const float excess = (squares - square(total) / count) / (count - 1) - explained;
  const float chance = explained * std::sqrt(2 / (count - 1));  // standard deviation of the excess under noise alone
  return excess > kClearly * chance ? excess : 0;
}

float predicted_variance(const std::vector<RefinedTile>& tiles, int columns, int rows, int column, int row) {
  // The shift at which mirrored half discs match differs from that of their centroids, depending on the texture that
  // they blur: measured on textures of 0.02 to 0.4 cycles a pixel.
  constexpr float kKernelError = 0.02f;      // over the square of the shift, per DP px ...
  constexpr float kMostKernelError = 0.08f;  // ... and at most, DP px
  // A tile measures the disparity at its texture, not its mean disparity. On a plane with texture at a single position
  // that gives a variance of 1/12 of the squared change from tile to tile, which is 1/9 of the roughness; the portrait
  // scene's foliage needs twice that.
  constexpr float kRoughnessShare = 0.25f;
  constexpr float kAgreement = 0.3f;  // difference on one surface, DP px, beside what both tiles' errors explain
  constexpr float kSupport = 0.625f;  // share of the neighbors that agree along a straight edge
  const RefinedTile& tile = tiles[static_cast<std::size_t>(row) * columns + column];
  const float kernel = std::min(kKernelError * square(tile.disparity), kMostKernelError);
  const float own =
      tile.noise + tile.model + square(kernel) + kRoughnessShare * roughness(tiles, columns, rows, column, row);
  if (!std::isfinite(own)) return own;
  float count = 0, agree = 0, against = 0;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x) {
      const RefinedTile& other = tiles[static_cast<std::size_t>(y) * columns + x];
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

}  // namespace dualpixel::pipeline::likelihood
