#include "pipeline/disparity/split/coarse_views.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/rows.h"
#include "pipeline/disparity/split/shading.h"

namespace dualpixel::pipeline::split {
namespace {

/// Position `i` mirrored into 0 .. size - 1.
int mirrored(int i, int size) {
  if (size == 1) return 0;
  const int period = 2 * size - 2;
  i = ((i % period) + period) % period;
  return i < size ? i : period - i;
}

/// -1 where that turned the direction, else 1.
float turned(int i, int size) {
  if (size == 1) return i == 0 ? 1 : -1;
  const int period = 2 * size - 2;
  i = ((i % period) + period) % period;
  return i < size ? 1 : -1;
}

bool is_usable(float value, float clipped) { return std::isfinite(value) && value < clipped; }

/// Sums over 2 x 2 pixels of both views, of those that are usable in both.
struct Halved {
  Image left, right, count;
};

Halved halve(const Image& left, const Image& right, int width, int height, float clipped) {
  Halved out{Image(width, height), Image(width, height), Image(width, height)};
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      for (int k = 0; k < 4; ++k) {
        const int u = 2 * x + k % 2, v = 2 * y + k / 2;
        if (u >= left.width || v >= left.height) continue;
        const float a = left.row(v)[u], b = right.row(v)[u];
        if (!is_usable(a, clipped) || !is_usable(b, clipped)) continue;
        out.left.at(x, y) += a;
        out.right.at(x, y) += b;
        out.count.at(x, y) += 1;
      }
    }
  });
  return out;
}

/// Both views at a quarter of their size, rounded, and the tiles' usable shares. A sample is a mean of the pixels
/// around it that are usable in both, and without such pixels not a number.
struct Reduced {
  Image left, right, usable;
};

/// Of halved pixels in a sample, along each axis. Of a period of 5 px, which is aliased to one of 20 px, means over 4
/// px would let ten times as much through.
constexpr float kWeights[] = {1, 3, 3, 1};
/// Variance of those weights, 2 px apart, and of the 2 x 2 means, px^2.
constexpr double kReducedVariance = 4 * 0.75 + 0.25;

Reduced reduce(const Image& left, const Image& right, float clipped) {
  static_assert(kSamplePx == 4 && kTileSamples == 2);
  const int columns = (left.width + kTilePx - 1) / kTilePx, rows = (left.height + kTilePx - 1) / kTilePx;
  const int width = std::max((left.width + kSamplePx / 2) / kSamplePx, 1);
  const int height = std::max((left.height + kSamplePx / 2) / kSamplePx, 1);
  const Halved half = halve(left, right, 2 * width, 2 * height, clipped);
  Reduced out{Image(width, height), Image(width, height), Image(columns, rows)};
  for_rows(rows, [&](int row) {
    for (int y = row * kTileSamples; y < std::min((row + 1) * kTileSamples, height); ++y) {
      for (int x = 0; x < width; ++x) {
        float l = 0, r = 0, count = 0;
        for (int j = 0; j < 4; ++j) {
          const int v = mirrored(2 * y + j - 1, half.left.height);
          for (int i = 0; i < 4; ++i) {
            const int u = 2 * x + i - 1;
            if (u < 0 || u >= half.left.width) continue;  // beyond it the views change places, when shading is out
            const float weight = kWeights[i] * kWeights[j];
            l += weight * half.left.at(u, v);
            r += weight * half.right.at(u, v);
            count += weight * half.count.at(u, v);
            const bool own = i > 0 && i < 3 && j > 0 && j < 3;
            if (own) out.usable.at(x / kTileSamples, row) += half.count.at(u, v) / (kTilePx * kTilePx);
          }
        }
        out.left.at(x, y) = l / count;  // 0 / 0: not a number
        out.right.at(x, y) = r / count;
      }
    }
  });
  return out;
}

/// Fills what is not a number along the row, from the samples on both sides of it; false where there are none.
bool fill_row(float* row, int width) {
  int before = -1;
  for (int x = 0; x <= width; ++x) {
    if (x < width && std::isnan(row[x])) continue;
    if (x == width && before < 0) return false;
    for (int i = before + 1; i < x; ++i) {
      const float along = static_cast<float>(i - before) / static_cast<float>(x - before);
      row[i] = before < 0 ? row[x] : x == width ? row[before] : row[before] + along * (row[x] - row[before]);
    }
    before = x;
  }
  return true;
}

/// Bridges what clips, lest its ends look like edges that both views share. Rows without any sample become as the
/// nearest that has one; where none has, all is 0.
void fill_gaps(Image& view) {
  std::vector<char> filled(view.height);
  for (int y = 0; y < view.height; ++y) filled[y] = fill_row(view.row(y), view.width);
  for (int y = 0; y < view.height; ++y) {
    if (filled[y]) continue;
    std::fill_n(view.row(y), view.width, 0.0f);
    for (int away = 1; away < view.height; ++away) {
      const int above = y - away, below = y + away;
      const int from = above >= 0 && filled[above] ? above : below < view.height && filled[below] ? below : -1;
      if (from < 0) continue;
      std::copy_n(view.row(from), view.width, view.row(y));
      break;
    }
  }
}

/// Mean square of both views' contrast under a Gaussian of `sigma` samples.
Image mean_power(const Image& sum, const Image& difference, double sigma) {
  Image power(sum.width, sum.height);
  for (std::size_t i = 0; i < power.data.size(); ++i) {
    power.data[i] = 0.25f * (sum.data[i] * sum.data[i] + difference.data[i] * difference.data[i]);
  }
  return gaussian(power, sigma, Mirror::even);
}

/// A highlight, or the outline of something near, has many times the contrast of what is beside it and would answer
/// for the whole window. Where the mean square contrast around a sample is over kCalm of the wide mean, it is weighted
/// by the inverse, so that all such places count alike.
Image weights_of_tiles(const Image& sum, const Image& difference, const Image& usable) {
  constexpr double kAround = 2;  // samples
  constexpr float kCalm = 0.3f;
  const Image power = mean_power(sum, difference, kAround);
  Image weight(usable.width, usable.height);
  for_rows(weight.height, [&](int row) {
    for (int column = 0; column < weight.width; ++column) {
      float total = 0;
      for (int i = 0; i < kTileSamples * kTileSamples; ++i) {
        const int x = std::min(column * kTileSamples + i % kTileSamples, power.width - 1);
        const int y = std::min(row * kTileSamples + i / kTileSamples, power.height - 1);
        total += 1 / std::max(1.0f, power.at(x, y) / kCalm);
      }
      weight.at(column, row) = total / (kTileSamples * kTileSamples);
    }
  });
  return weight;
}

/// The image of all tiles, with `margin` mirrored samples on each side.
Image padded(const Image& image, const Image& tiles, int margin, Mirror sides) {
  Image out(tiles.width * kTileSamples + 2 * margin, tiles.height * kTileSamples + 2 * margin);
  for_rows(out.height, [&](int y) {
    const float* in = image.row(mirrored(y - margin, image.height));
    for (int x = 0; x < out.width; ++x) {
      const float sign = sides == Mirror::odd ? turned(x - margin, image.width) : 1;
      out.row(y)[x] = sign * in[mirrored(x - margin, image.width)];
    }
  });
  return out;
}

}  // namespace

Image gaussian(const Image& image, double sigma, Mirror sides) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  std::vector<float> taps(reach + 1);
  double total = 0;
  for (int i = 0; i <= reach; ++i) {
    taps[i] = static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)));
    total += (i == 0 ? 1 : 2) * taps[i];
  }
  for (float& tap : taps) tap = static_cast<float>(tap / total);
  Image out(image.width, image.height);
  for_rows(image.height, [&](int y) {
    std::vector<float> line(image.width + 2 * reach);
    float* middle = line.data() + reach;
    for (int x = 0; x < image.width; ++x) middle[x] = taps[0] * image.row(y)[x];
    for (int i = 1; i <= reach; ++i) {
      const float* above = image.row(mirrored(y - i, image.height));
      const float* below = image.row(mirrored(y + i, image.height));
      for (int x = 0; x < image.width; ++x) middle[x] += taps[i] * (above[x] + below[x]);
    }
    for (int i = 1; i <= reach; ++i) {
      for (const int x : {-i, image.width - 1 + i}) {
        middle[x] = (sides == Mirror::odd ? turned(x, image.width) : 1) * middle[mirrored(x, image.width)];
      }
    }
    float* to = out.row(y);
    for (int x = 0; x < image.width; ++x) to[x] = taps[0] * middle[x];
    for (int i = 1; i <= reach; ++i) {
      for (int x = 0; x < image.width; ++x) to[x] += taps[i] * (middle[x - i] + middle[x + i]);
    }
  });
  return out;
}

CoarseViews make_coarse_views(const Image& left, const Image& right, const SplitMatchOptions& options, int margin) {
  constexpr double kShadingReach = 0.06;    // standard deviation of the window of the local ratio, of the width,
  constexpr double kShadingPasses = 4;      // and of the high-pass: a narrower one would take disparity for shading
  constexpr float kLeastContrast = 0.004f;  // over the local mean, that counts as contrast
  constexpr float kLeastSignal = 1e-4f;
  Reduced views = reduce(left, right, options.clipped * options.white);
  fill_gaps(views.left);
  fill_gaps(views.right);
  even_out_shading(views.left, views.right);
  const int width = views.left.width, height = views.left.height;
  const std::size_t size = views.left.data.size();

  const double high_pass = options.high_pass_px / kSamplePx;
  const double window = std::max(kShadingReach * width, kShadingPasses * high_pass);
  const Image wide_left = gaussian(views.left, window, Mirror::even);
  const Image wide_right = gaussian(views.right, window, Mirror::even);
  for (std::size_t i = 0; i < size; ++i) {
    const float ratio = wide_right.data[i] / wide_left.data[i];
    const float gain = ratio > 0.0625f && ratio < 16 ? std::sqrt(ratio) : 1.0f;  // beyond that, or 0 / 0, no shading
    views.left.data[i] *= gain;
    views.right.data[i] /= gain;
  }
  const double own = (std::pow(options.low_pass_px, 2) - kReducedVariance) / (kSamplePx * kSamplePx) -
                     kFilterSmoothing * kFilterSmoothing;
  Image sum(width, height), difference(width, height);
  for (std::size_t i = 0; i < size; ++i) {
    sum.data[i] = views.left.data[i] + views.right.data[i];
    difference.data[i] = views.left.data[i] - views.right.data[i];
  }
  sum = gaussian(sum, std::sqrt(own), Mirror::even);
  difference = gaussian(difference, std::sqrt(own), Mirror::odd);
  const Image mean_sum = gaussian(sum, high_pass, Mirror::even);
  const Image mean_difference = gaussian(difference, high_pass, Mirror::odd);
  for (std::size_t i = 0; i < size; ++i) {
    const float mean = std::max(0.5f * mean_sum.data[i], kLeastSignal);
    sum.data[i] = (sum.data[i] - mean_sum.data[i]) / mean;
    difference.data[i] = (difference.data[i] - mean_difference.data[i]) / mean;
  }
  const Image power = mean_power(sum, difference, high_pass);
  for (std::size_t i = 0; i < size; ++i) {
    const float scale = 1 / std::sqrt(power.data[i] + kLeastContrast * kLeastContrast);
    sum.data[i] *= scale;
    difference.data[i] *= scale;
  }
  Image weight = weights_of_tiles(sum, difference, views.usable);
  return {margin,
          views.usable.width,
          views.usable.height,
          padded(sum, views.usable, margin, Mirror::even),
          padded(difference, views.usable, margin, Mirror::odd),
          std::move(views.usable),
          std::move(weight)};
}

}  // namespace dualpixel::pipeline::split
