#include "evaluation/baselines/six_channel_merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "capture/image/rows.h"
#include "pipeline/burst/fft16.h"
#include "pipeline/burst/require.h"

namespace dualpixel::evaluation {
namespace {

using namespace pipeline::fft16;

constexpr int kChannels = 6;               ///< R, G, G, B, left, right
constexpr int kTilePairs = kChannels / 2;  ///< two channels make one complex tile
constexpr int kHalf = kTile / 2;
constexpr float kWindowEnergy = kTile * kTile * 9.0f / 64;  ///< sum of the squared window
constexpr float kRounding = 1.0f / 12;                      ///< variance, DN^2

/// The window at x - shift.
std::array<float, kTile> shifted_window(float shift) {
  std::array<float, kTile> window;
  for (int x = 0; x < kTile; ++x) {
    const float angle = 2 * std::numbers::pi_v<float> / kTile * (static_cast<float>(x) - shift + 0.5f);
    window[x] = 0.5f - 0.5f * std::cos(angle);
  }
  return window;
}

/// DN above black, all of the Bayer planes' size.
using Channels = std::array<Image, kChannels>;

/// Twice as high: even rows are the view's.
Image enlarged(const ImageU16& view, float black) {
  Image large(view.width, 2 * view.height);
  for (int y = 0; y < large.height; ++y) {
    const int above = y / 2, below = std::min((y + 1) / 2, view.height - 1);
    for (int x = 0; x < large.width; ++x) {
      large.at(x, y) = 0.5f * static_cast<float>(view.at(x, above) + view.at(x, below)) - black;
    }
  }
  return large;
}

Channels channels_of(const Frame& frame, float black) {
  Channels channels;
  for (int plane = 0; plane < 4; ++plane) {
    channels[plane] = Image(frame.mosaic.width / 2, frame.mosaic.height / 2);
    for (int y = 0; y < channels[plane].height; ++y) {
      for (int x = 0; x < channels[plane].width; ++x) {
        channels[plane].at(x, y) = static_cast<float>(frame.mosaic.at(2 * x + plane % 2, 2 * y + plane / 2)) - black;
      }
    }
  }
  channels[4] = enlarged(frame.left, black);
  channels[5] = enlarged(frame.right, black);
  return channels;
}

int reflected(int i, int size) { return std::clamp(i < 0 ? -1 - i : i < size ? i : 2 * size - 1 - i, 0, size - 1); }

/// Spectra of the six channels' windowed tiles at (x0, y0) plus a shift; `mean_square` becomes each channel's.
struct Spectra {
  ComplexTile pairs[kTilePairs];
  std::array<float, kChannels> mean_square{};
};

Phases phases_of(float shift) {
  Phases phases;
  for (int k = 0; k < kTile; ++k) {
    const float angle = 2 * std::numbers::pi_v<float> / kTile * static_cast<float>(k < kHalf ? k : k - kTile) * shift;
    phases.re[k] = std::cos(angle);
    phases.im[k] = k == kHalf ? 0 : std::sin(angle);  // the highest frequency is as much negative as positive
  }
  return phases;
}

void load(const Channels& channels, int x0, int y0, float shift_x, float shift_y, Spectra& spectra) {
  const float whole_x = std::round(shift_x), whole_y = std::round(shift_y);
  const float part_x = shift_x - whole_x, part_y = shift_y - whole_y;
  const int left = x0 + static_cast<int>(whole_x), top = y0 + static_cast<int>(whole_y);
  const std::array<float, kTile> across = shifted_window(part_x), down = shifted_window(part_y);
  for (int c = 0; c < kChannels; ++c) {
    const Image& channel = channels[c];
    ComplexTile& tile = spectra.pairs[c / 2];
    float squares = 0;
    for (int y = 0; y < kTile; ++y) {
      const float* row = channel.row(reflected(top + y, channel.height));
      for (int x = 0; x < kTile; ++x) {
        const float value = row[reflected(left + x, channel.width)];
        squares += value * value;
        (c % 2 == 0 ? tile.re : tile.im)[y][x / kLanes][x % kLanes] = value * down[y] * across[x];
      }
    }
    spectra.mean_square[c] = squares / (kTile * kTile);
  }
  const Phases along_x = phases_of(part_x), along_y = phases_of(part_y);
  for (ComplexTile& tile : spectra.pairs) transform(tile, along_x, along_y);
}

/// c V at each ky, summed over the channels of a tile.
std::array<float, kTile> thresholds(const Spectra& base, const Exposure& exposure, float strength) {
  const auto variance = [&](int channel, const NoiseProfile& noise) {
    return std::max(
        static_cast<float>(noise.shot_dn) * std::sqrt(base.mean_square[channel]) + static_cast<float>(noise.read_dn2),
        kRounding);
  };
  float planes = 0, views = 0;
  for (int c = 0; c < 4; ++c) planes += variance(c, exposure.mosaic_noise);
  for (int c = 4; c < kChannels; ++c) views += variance(c, exposure.dp_noise);
  std::array<float, kTile> all;
  for (int ky = 0; ky < kTile; ++ky) {
    const float smoothing = 1 + std::cos(2 * std::numbers::pi_v<float> / kTile * static_cast<float>(ky));
    all[ky] = strength * 2 * kWindowEnergy * (planes + 0.5f * smoothing * smoothing * views);
  }
  return all;
}

/// merged += share (T_z + A D) for D = base - other.
void add(const Spectra& base, const Spectra& other, const std::array<float, kTile>& limits, float share,
         Spectra& merged) {
  for (int kx = 0; kx < kTile; ++kx) {
    for (int ky = 0; ky < kTile; ++ky) {
      const int half = ky / kLanes, lane = ky % kLanes;
      const int mirror_half = (kTile - ky) % kTile / kLanes, mirror_lane = (kTile - ky) % kTile % kLanes;
      float power = 0;  // |A|^2 + |B|^2 of a complex tile: half of |Z(k)|^2 + |Z(-k)|^2
      for (int p = 0; p < kTilePairs; ++p) {
        const ComplexTile &a = base.pairs[p], &b = other.pairs[p];
        const int mirror = (kTile - kx) % kTile;
        const float re = a.re[kx][half][lane] - b.re[kx][half][lane];
        const float im = a.im[kx][half][lane] - b.im[kx][half][lane];
        const float mirror_re = a.re[mirror][mirror_half][mirror_lane] - b.re[mirror][mirror_half][mirror_lane];
        const float mirror_im = a.im[mirror][mirror_half][mirror_lane] - b.im[mirror][mirror_half][mirror_lane];
        power += 0.5f * (re * re + im * im + mirror_re * mirror_re + mirror_im * mirror_im);
      }
      const float kept = share * limits[ky] / (power + limits[ky]);
      for (int p = 0; p < kTilePairs; ++p) {
        const ComplexTile &a = base.pairs[p], &b = other.pairs[p];
        ComplexTile& to = merged.pairs[p];
        to.re[kx][half][lane] -= kept * (a.re[kx][half][lane] - b.re[kx][half][lane]);
        to.im[kx][half][lane] -= kept * (a.im[kx][half][lane] - b.im[kx][half][lane]);
      }
    }
  }
}

void add_tile(Spectra& merged, int x0, int y0, Channels& out) {
  constexpr float kScale = 1.0f / (kTile * kTile);
  for (ComplexTile& tile : merged.pairs) transform_back(tile);
  for (int c = 0; c < kChannels; ++c) {
    const ComplexTile& tile = merged.pairs[c / 2];
    for (int y = std::max(-y0, 0); y < std::min(kTile, out[c].height - y0); ++y) {
      for (int x = std::max(-x0, 0); x < std::min(kTile, out[c].width - x0); ++x) {
        out[c].at(x0 + x, y0 + y) += kScale * (c % 2 == 0 ? tile.re : tile.im)[y][x / kLanes][x % kLanes];
      }
    }
  }
}

pipeline::MergedBurst merged_burst(const Channels& channels, float range) {
  const int width = channels[0].width, height = channels[0].height;
  pipeline::MergedBurst merged{Image(2 * width, 2 * height), Image(width, height / 2), Image(width, height / 2)};
  for (int y = 0; y < merged.mosaic.height; ++y) {
    for (int x = 0; x < merged.mosaic.width; ++x) {
      merged.mosaic.at(x, y) = channels[2 * (y % 2) + x % 2].at(x / 2, y / 2) / range;
    }
  }
  for (int y = 0; y < merged.left.height; ++y) {
    for (int x = 0; x < width; ++x) {
      merged.left.at(x, y) = channels[4].at(x, 2 * y) / range;
      merged.right.at(x, y) = channels[5].at(x, 2 * y) / range;
    }
  }
  return merged;
}

}  // namespace

pipeline::MergedBurst merge_six_channels(const std::vector<Frame>& frames, int base,
                                         const std::vector<pipeline::MotionField>& motions, const Exposure& exposure) {
  pipeline::require_burst(frames, exposure);
  const Frame& first = frames.front();
  pipeline::require(!first.mosaic.empty() && 2 * first.left.width == first.mosaic.width &&
                        4 * first.left.height == first.mosaic.height,
                    "six channels need a mosaic, and views as wide as a Bayer plane and half as high");
  const auto black = static_cast<float>(exposure.black_level_dn);
  std::vector<Channels> all;
  for (const Frame& frame : frames) all.push_back(channels_of(frame, black));
  const int width = all[0][0].width, height = all[0][0].height;
  Channels sum;
  sum.fill(Image(width, height));
  const float share = 1 / static_cast<float>(frames.size());
  const auto strength = static_cast<float>(pipeline::MergeOptions().strength);
  const auto merge_row = [&](int j) {
    for (int i = 0; i < motions[0].width; ++i) {
      const int x0 = (i - 1) * kHalf, y0 = (j - 1) * kHalf;
      Spectra reference, other;
      load(all[base], x0, y0, 0, 0, reference);
      const std::array<float, kTile> limits = thresholds(reference, exposure, strength);
      Spectra merged = reference;
      for (std::size_t z = 0; z < frames.size(); ++z) {
        if (static_cast<int>(z) == base) continue;
        load(all[z], x0, y0, motions[z].at(i, j, 0), motions[z].at(i, j, 1), other);
        add(reference, other, limits, share, merged);
      }
      add_tile(merged, x0, y0, sum);
    }
  };
  // Tiles overlap the rows of tiles next to theirs: first every other row, then those between.
  for (int parity = 0; parity < 2; ++parity) {
    for_rows((motions[0].height + 1 - parity) / 2, [&](int k) { merge_row(2 * k + parity); });
  }
  pipeline::MergedBurst merged = merged_burst(sum, static_cast<float>(exposure.white_level_dn) - black);
  merged.base_frame = base;
  return merged;
}

}  // namespace dualpixel::evaluation
