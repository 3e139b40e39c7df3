#include "pipeline/disparity/likelihood/prepared_views.h"

#include <algorithm>
#include <cmath>

#include "capture/image/resample.h"
#include "capture/image/rows.h"

namespace dualpixel::pipeline::likelihood {
namespace {

constexpr float kLeastVariance = 1e-12f;  // of shot noise in the dark

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
PreparedView prepare(const Image& view, const Image& gain, int margin, const ViewNoise& noise, float clipped) {
  const int stride = gain.width * kTile + 2 * margin;
  const int rows = gain.height * kTile;
  PreparedView out{margin, Image(stride, rows), Image(stride, rows), Image(stride, rows, 1, kInvalidVariance)};
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
    for (int x = kInvalidMargin; x < view.width - kInvalidMargin; ++x) {
      variance[margin + x] =
          factor[x] * (noise.shot * std::max(smooth[margin + x], 0.0f) + factor[x] * noise.read) + kLeastVariance;
    }
    for (int x = 0; x < view.width; ++x) all_usable &= usable(in[x], clipped);
    if (all_usable) return;
    for (int x = 0; x < view.width; ++x) {
      if (!usable(in[x], clipped))
        std::fill_n(variance + margin + x - kInvalidMargin, 2 * kInvalidMargin + 1, kInvalidVariance);
    }
  });
  return out;
}

}  // namespace

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

PreparedViews prepare_views(const Image& left, const Image& right, int margin, const ViewNoise& noise, float clipped) {
  Image gain = shading_gain(left, right, clipped);
  PreparedViews views{
      prepare(left, gain, margin, noise, clipped), {}, gain.width, gain.height, left.width, left.height};
  for (float& value : gain.data) value = 1 / value;
  views.right = prepare(right, gain, margin, noise, clipped);
  return views;
}

}  // namespace dualpixel::pipeline::likelihood
