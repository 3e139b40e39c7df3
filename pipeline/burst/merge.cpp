#include "pipeline/burst/merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

#include "capture/image/rows.h"
#include "pipeline/burst/align.h"
#include "pipeline/burst/fft16.h"
#include "pipeline/burst/require.h"

namespace dualpixel::pipeline {
namespace {

using namespace fft16;
static_assert(kTile == kMotionTile);  // a motion for each tile
constexpr int kHalfTile = kMotionStep;
constexpr float kWindowEnergy = kTile * kTile * 9.0f / 64;  // (mean of the squared window = 3/8) along each axis

/// Two planes of one size that are merged side by side: pixel (x, y) of each is at [y * stride + x * step].
template <typename T>
struct PlanePair {
  T* first;
  T* second;
  std::ptrdiff_t stride;
};

/// Parameters that all tiles of a pair of planes share.
struct PairShape {
  int width, height;
  float motion_x, motion_y;  ///< pixels per Bayer px
  float black;               ///< DN
  float range;               ///< DN from black to white, the normalized signal 1
  float clipped;             ///< from here on a plane is clipped, DN above black
  float clipped_noise;       ///< variance where it is
  float shot, read;          ///< variance = shot * (DN - black) + read
  float strength;
};

/// cos and sin of the phases of a shift by `delta` px, |delta| <= 1/2.
struct Turn {
  float c, s;
  explicit Turn(float delta) {
    const float angle = 2 * std::numbers::pi_v<float> / kTile * delta;
    c = std::cos(angle);
    s = std::sin(angle);
  }
};

/// Spectrum of f(x + delta) over that of f(x). The highest frequency is as much negative as positive.
Phases shift_phases(const Turn& turn) {
  Phases phases;
  float c = 1, s = 0;
  for (int k = 0; k < kTile / 2; ++k) {
    phases.re[k] = c;
    phases.im[k] = s;
    phases.re[(kTile - k) % kTile] = c;
    phases.im[(kTile - k) % kTile] = -s;
    const float next = c * turn.c - s * turn.s;
    s = s * turn.c + c * turn.s;
    c = next;
  }
  phases.im[0] = 0;
  phases.re[kTile / 2] = c;
  phases.im[kTile / 2] = 0;
  return phases;
}

struct Window {
  float at[kTile];
};

/// The window at x - delta.
Window shifted_window(const Turn& turn) {
  static const auto waves = [] {
    std::array<std::array<float, kTile>, 2> table;
    for (int x = 0; x < kTile; ++x) {
      const double angle = 2 * std::numbers::pi / kTile * (x + 0.5);
      table[0][x] = static_cast<float>(0.5 * std::cos(angle));
      table[1][x] = static_cast<float>(0.5 * std::sin(angle));
    }
    return table;
  }();
  Window window;
  for (int x = 0; x < kTile; ++x) window.at[x] = 0.5f - (waves[0][x] * turn.c + waves[1][x] * turn.s);
  return window;
}

/// Sixteen samples of a row of both planes, whose samples alternate (step 2) or lie in two images (step 1).
template <int step>
void load_row(const std::uint16_t* first, const std::uint16_t* second, Lanes (&to_first)[kHalves],
              Lanes (&to_second)[kHalves]) {
  using Integers = std::int32_t __attribute__((vector_size(32)));
  for (int half = 0; half < kHalves; ++half) {
    Integers a, b;
    if constexpr (step == 2) {
      static_assert(std::endian::native == std::endian::little);  // the first of a couple is the lower half
      std::uint32_t __attribute__((vector_size(32))) couples;
      std::memcpy(&couples, first + step * kLanes * half, sizeof(couples));
      a = Integers(couples & 0xffff);
      b = Integers(couples >> 16);
    } else {
      std::uint16_t __attribute__((vector_size(16))) words;
      std::memcpy(&words, first + kLanes * half, sizeof(words));
      a = __builtin_convertvector(words, Integers);
      std::memcpy(&words, second + kLanes * half, sizeof(words));
      b = __builtin_convertvector(words, Integers);
    }
    to_first[half] = __builtin_convertvector(a, Lanes);
    to_second[half] = __builtin_convertvector(b, Lanes);
  }
}

/// Index of the sample that a mirror along the border shows at `i`; far beyond it, of the last one that it can show.
/// (Repeated border pixels would lack the noise of fine detail that the test of energies expects.)
int reflected(int i, int size) { return std::clamp(i < 0 ? -1 - i : i < size ? i : 2 * size - 1 - i, 0, size - 1); }

/// Both planes' tile at (x0, y0), minus black; beyond the planes it shows their mirror image.
template <int step>
void load(const PlanePair<const std::uint16_t>& planes, const PairShape& shape, int x0, int y0, ComplexTile& tile) {
  const bool inside = x0 >= 0 && x0 + kTile <= shape.width;
  for (int y = 0; y < kTile; ++y) {
    const std::ptrdiff_t row = reflected(y0 + y, shape.height) * planes.stride;
    if (inside) {
      const std::ptrdiff_t at = row + static_cast<std::ptrdiff_t>(x0) * step;
      load_row<step>(planes.first + at, planes.second + at, tile.re[y], tile.im[y]);
    } else {
      std::uint16_t first[kTile], second[kTile];
      for (int x = 0; x < kTile; ++x) {
        const std::ptrdiff_t at = row + static_cast<std::ptrdiff_t>(reflected(x0 + x, shape.width)) * step;
        first[x] = planes.first[at];
        second[x] = planes.second[at];
      }
      load_row<1>(first, second, tile.re[y], tile.im[y]);
    }
    for (int half = 0; half < kHalves; ++half) {
      tile.re[y][half] -= shape.black;
      tile.im[y][half] -= shape.black;
    }
  }
}

void apply_window(ComplexTile& tile, const Window& across, const Window& down) {
  for (int half = 0; half < kHalves; ++half) {
    const Lanes w = load_lanes(across.at + kLanes * half);
    for (int y = 0; y < kTile; ++y) {
      tile.re[y][half] *= w * down.at[y];
      tile.im[y][half] *= w * down.at[y];
    }
  }
}

float root_mean_square(const Lanes (&plane)[kTile][kHalves]) {
  Lanes squares{};
  for (const auto& row : plane) {
    for (const Lanes& part : row) squares += part * part;
  }
  return std::sqrt(sum(squares) / (kTile * kTile));
}

/// The part of the difference of two tiles that noise explains, DN^2.
struct TileNoise {
  float first_threshold, second_threshold;  ///< c V of each plane
  float energy;                             ///< expected sum of |D|^2 / kTile^2 over both planes
  bool clips;                               ///< any pixel of the base's tile, in either plane
};

constexpr float kRounding = 1.0f / 12;

float threshold(const Lanes (&plane)[kTile][kHalves], const PairShape& shape) {
  const float variance = shape.shot * root_mean_square(plane) + shape.read;
  return shape.strength * 2 * kWindowEnergy * std::max(variance, kRounding);
}

/// Sums each pixel's own variance under the squared window. Sets `clips` where a pixel does.
float noise_energy(const Lanes (&plane)[kTile][kHalves], const Window& window, const PairShape& shape, bool& clips) {
  const Lanes rounding = Lanes{} + kRounding, clipped = Lanes{} + shape.clipped_noise;
  Lanes energy{}, largest{};
  for (int half = 0; half < kHalves; ++half) {
    const Lanes across = load_lanes(window.at + kLanes * half);
    for (int y = 0; y < kTile; ++y) {
      const Lanes w = across * window.at[y];
      const Lanes signal = plane[y][half];
      const Lanes variance = shape.shot * signal + shape.read;
      largest = signal > largest ? signal : largest;
      energy += signal < shape.clipped ? w * w * (variance > rounding ? variance : rounding) : w * w * clipped;
    }
  }
  for (int lane = 0; lane < kLanes; ++lane) clips |= largest[lane] >= shape.clipped;
  return 2 * sum(energy);
}

TileNoise tile_noise(const ComplexTile& tile, const Window& window, const PairShape& shape) {
  bool clips = false;
  const float energy = noise_energy(tile.re, window, shape, clips) + noise_energy(tile.im, window, shape, clips);
  return {threshold(tile.re, shape), threshold(tile.im, shape), energy, clips};
}

/// The share of a frame's tile that is merged, from the ratio of its energy to the expected one: 1 up to a ratio of
/// `full_trust`. Tiles that are clipped in both frames have 0 over 0, and are merged.
float trust(float energy, float expected, float full_trust) {
  constexpr float kRamp = 0.4f;
  if (energy <= full_trust * expected) return 1;
  return std::clamp(full_trust + kRamp - energy / expected, 0.0f, kRamp) / kRamp;
}

/// The lowest frequencies, over which the window spreads a tile's mean.
constexpr bool holds_mean(int k) { return k <= 1 || k == kTile - 1; }
constexpr int kMeanRows = 3;

/// Over a row of a spectrum: 0 where the mean is, 1 elsewhere.
Lanes beyond_the_mean(int half) {
  Lanes mask;
  for (int lane = 0; lane < kLanes; ++lane) mask[lane] = holds_mean(kLanes * half + lane) ? 0 : 1;
  return mask;
}

/// trust() of each column of a spectrum from the columns' sums of |D|^2, taken together in `Bands` bands of |ky|;
/// `with_mean`: nothing is left out of the sums.
template <int Bands>
void trust_columns(const Lanes (&energies)[kHalves], float noise_energy, bool with_mean, Lanes (&trusted)[kHalves]) {
  constexpr float kFullTrust =
      Bands == 1 ? 1.4f : 1.9f;  // noise alone gives the ratio a standard deviation of 0.12 and 0.17
  float columns[kTile];
  std::memcpy(columns, energies, sizeof(columns));
  const auto band = [](int ky) { return std::min(std::min(ky, kTile - ky) * Bands / kHalfTile, Bands - 1); };
  float energy[Bands] = {}, expected[Bands] = {};
  for (int ky = 0; ky < kTile; ++ky) {
    energy[band(ky)] += columns[ky];
    const bool all = with_mean || !holds_mean(ky);
    expected[band(ky)] += static_cast<float>(all ? kTile : kTile - kMeanRows) * noise_energy;
  }
  for (int ky = 0; ky < kTile; ++ky) columns[ky] = trust(energy[band(ky)], expected[band(ky)], kFullTrust);
  std::memcpy(trusted, columns, sizeof(columns));
}

/// Row -k of a spectrum, its columns reversed as well.
inline Lanes mirror_lanes(const Lanes (&spectrum)[kTile][kHalves], int row, int half) {
  const Lanes(&from)[kHalves] = spectrum[(kTile - row) % kTile];
  return __builtin_shufflevector(from[half], from[1 - half], 0, 15, 14, 13, 12, 11, 10, 9);
}

/// merged -= share (1 - A) D for D = base - other.
template <bool together>
void subtract_difference(const ComplexTile& base, const ComplexTile& other, const TileNoise& noise, float share,
                         ComplexTile& merged) {
  ComplexTile d;
  const Lanes beyond[kHalves] = {beyond_the_mean(0), beyond_the_mean(1)};
  Lanes energies[kHalves] = {};
  for (int row = 0; row < kTile; ++row) {
    for (int half = 0; half < kHalves; ++half) {
      const Lanes re = base.re[row][half] - other.re[row][half], im = base.im[row][half] - other.im[row][half];
      d.re[row][half] = re;
      d.im[row][half] = im;
      const Lanes power = re * re + im * im;
      energies[half] += holds_mean(row) && !noise.clips ? power * beyond[half] : power;
    }
  }
  Lanes shares[kHalves];
  trust_columns<together ? 2 : 1>(energies, noise.energy, noise.clips, shares);
  for (Lanes& trusted : shares) trusted *= share;
  for (int row = 0; row < kTile; ++row) {
    for (int half = 0; half < kHalves; ++half) {
      const Lanes re = d.re[row][half], im = d.im[row][half];
      const Lanes mirror_re = mirror_lanes(d.re, row, half), mirror_im = mirror_lanes(d.im, row, half);
      if constexpr (together) {
        const Lanes power = 0.5f * (re * re + im * im + mirror_re * mirror_re + mirror_im * mirror_im);
        const float limit = noise.first_threshold + noise.second_threshold;
        const Lanes kept = shares[half] * limit / (power + limit);
        merged.re[row][half] -= kept * re;
        merged.im[row][half] -= kept * im;
      } else {
        // first plane: half the sum with the mirrored conjugate; second: half the difference
        const Lanes first_re = re + mirror_re, first_im = im - mirror_im;
        const Lanes second_re = re - mirror_re, second_im = im + mirror_im;
        const Lanes first_power = 0.25f * (first_re * first_re + first_im * first_im);
        const Lanes second_power = 0.25f * (second_re * second_re + second_im * second_im);
        const Lanes half_share = 0.5f * shares[half];
        const Lanes first_kept = half_share * noise.first_threshold / (first_power + noise.first_threshold);
        const Lanes second_kept = half_share * noise.second_threshold / (second_power + noise.second_threshold);
        merged.re[row][half] -= first_kept * first_re + second_kept * second_re;
        merged.im[row][half] -= first_kept * first_im + second_kept * second_im;
      }
    }
  }
}

/// Adds a merged tile to the planes that it overlaps.
template <int step>
void add_tile(const ComplexTile& tile, const PairShape& shape, int x0, int y0, const PlanePair<float>& planes) {
  const float scale = 1 / (shape.range * kTile * kTile);
  for (int y = std::max(-y0, 0); y < std::min(kTile, shape.height - y0); ++y) {
    alignas(Lanes) float first[kTile], second[kTile];
    std::memcpy(first, tile.re[y], sizeof(first));
    std::memcpy(second, tile.im[y], sizeof(second));
    const std::ptrdiff_t at = (y0 + y) * planes.stride + static_cast<std::ptrdiff_t>(x0) * step;
    for (int x = std::max(-x0, 0); x < std::min(kTile, shape.width - x0); ++x) {
      planes.first[at + x * step] += scale * first[x];
      planes.second[at + x * step] += scale * second[x];
    }
  }
}

/// Merges one pair of planes of all frames into `out`, which is 0 before.
template <int step, bool together>
void merge_pair(const std::vector<PlanePair<const std::uint16_t>>& frames, int base,
                const std::vector<MotionField>& motions, const PairShape& shape, const PlanePair<float>& out) {
  const int columns = motion_tiles(shape.width), rows = motion_tiles(shape.height);
  const float share = 1 / static_cast<float>(frames.size());
  const Window window = shifted_window(Turn(0));
  const auto merge_row = [&](int j) {
    const int y0 = (j - 1) * kHalfTile;
    const int v =
        std::min(static_cast<int>(std::lround(static_cast<float>(j) / shape.motion_y)), motions[0].height - 1);
    for (int i = 0; i < columns; ++i) {
      const int x0 = (i - 1) * kHalfTile;
      const int u =
          std::min(static_cast<int>(std::lround(static_cast<float>(i) / shape.motion_x)), motions[0].width - 1);
      ComplexTile reference, other;
      load<step>(frames[base], shape, x0, y0, reference);
      const TileNoise noise = tile_noise(reference, window, shape);
      apply_window(reference, window, window);
      transform(reference);
      ComplexTile merged = reference;
      for (int z = 0; z < static_cast<int>(frames.size()); ++z) {
        if (z == base) continue;
        const auto far_x = static_cast<float>(shape.width), far_y = static_cast<float>(shape.height);
        const float x = std::clamp(motions[z].at(u, v, 0) * shape.motion_x, -far_x, far_x);
        const float y = std::clamp(motions[z].at(u, v, 1) * shape.motion_y, -far_y, far_y);
        const float whole_x = std::round(x), whole_y = std::round(y);
        const Turn turn_x(x - whole_x), turn_y(y - whole_y);
        load<step>(frames[z], shape, x0 + static_cast<int>(whole_x), y0 + static_cast<int>(whole_y), other);
        apply_window(other, shifted_window(turn_x), shifted_window(turn_y));
        transform(other, shift_phases(turn_x), shift_phases(turn_y));
        subtract_difference<together>(reference, other, noise, share, merged);
      }
      transform_back(merged);
      add_tile<step>(merged, shape, x0, y0, out);
    }
  };
  // rows of tiles overlap their neighbors only: first every other one, then those between
  for (int parity = 0; parity < 2; ++parity) {
    for_rows((rows + 1 - parity) / 2, [&](int k) { merge_row(2 * k + parity); });
  }
}

/// Sets where planes clip whose own white is `white_dn`, empty: at the normalized signal 1. A full well is read out
/// with noise, on either side of its level; at the end of the range even that is cut.
void clip_at(std::optional<double> white_dn, PairShape& shape) {
  const float white = white_dn ? static_cast<float>(*white_dn) - shape.black : shape.range;
  const bool read_out = white < shape.range;
  shape.clipped = read_out ? white - 3 * std::sqrt(shape.read) : shape.range;
  shape.clipped_noise = read_out ? std::max(shape.read, kRounding) : 0;
}

}  // namespace

OptionFields fields(MergeOptions& options) {
  return {{"strength", &options.strength, 1e-3, 1e6, "", "Hasinoff et al. 2016, S: 8"}};
}

MergedBurst merge_burst(const std::vector<Frame>& frames, int base, const std::vector<MotionField>& motions,
                        const Exposure& exposure, const MergeOptions& options) {
  require_burst(frames, exposure);
  require(base >= 0 && base < static_cast<int>(frames.size()),
          fmt::format("base: {}: must be in [0, {}]", base, frames.size() - 1));
  check_options("merge", options);
  const Frame& first = frames.front();
  const auto [width, height] = plane_size(first);
  require(motions.size() == frames.size(), "one motion field is needed for each frame");
  for (const MotionField& motion : motions) {
    require(motion.width == motion_tiles(width) && motion.height == motion_tiles(height) && motion.channels == 2,
            "a motion field must have two channels and one pixel for each tile");
    require(std::all_of(motion.data.begin(), motion.data.end(), [](float m) { return std::isfinite(m); }),
            "motions must be finite");
  }

  PairShape shape;
  shape.black = static_cast<float>(exposure.black_level_dn);
  shape.range = static_cast<float>(exposure.white_level_dn) - shape.black;
  shape.strength = static_cast<float>(options.strength);
  std::vector<PlanePair<const std::uint16_t>> pairs(frames.size());
  MergedBurst merged;
  merged.base_frame = base;
  if (!first.mosaic.empty()) {
    merged.mosaic = Image(first.mosaic.width, first.mosaic.height);
    shape.width = width;
    shape.height = height;
    shape.motion_x = shape.motion_y = 1;
    shape.shot = static_cast<float>(exposure.mosaic_noise.shot_dn);
    shape.read = static_cast<float>(exposure.mosaic_noise.read_dn2);
    clip_at(exposure.mosaic_white_level_dn, shape);
    const std::ptrdiff_t stride = 2 * first.mosaic.width;
    for (int line = 0; line < 2; ++line) {  // of each 2 x 2 photosites
      for (std::size_t z = 0; z < frames.size(); ++z) {
        const std::uint16_t* row = frames[z].mosaic.row(line);
        pairs[z] = {row, row + 1, stride};
      }
      float* row = merged.mosaic.row(line);
      merge_pair<2, false>(pairs, base, motions, shape, {row, row + 1, stride});
    }
  }
  if (first.left.empty()) return merged;
  merged.left = Image(first.left.width, first.left.height);
  merged.right = merged.left;
  shape.width = first.left.width;
  shape.height = first.left.height;
  shape.motion_x = static_cast<float>(shape.width) / static_cast<float>(width);
  shape.motion_y = static_cast<float>(shape.height) / static_cast<float>(height);
  shape.shot = static_cast<float>(exposure.dp_noise.shot_dn);
  shape.read = static_cast<float>(exposure.dp_noise.read_dn2);
  clip_at(exposure.dp_white_level_dn, shape);
  for (std::size_t z = 0; z < frames.size(); ++z) {
    pairs[z] = {frames[z].left.row(0), frames[z].right.row(0), shape.width};
  }
  merge_pair<1, true>(pairs, base, motions, shape, {merged.left.row(0), merged.right.row(0), shape.width});
  return merged;
}

MergedBurst align_and_merge(const std::vector<Frame>& frames, const Exposure& exposure, const MergeOptions& options) {
  const int base = sharpest_frame(frames, exposure);
  return merge_burst(frames, base, align_burst(frames, base, exposure), exposure, options);
}

}  // namespace dualpixel::pipeline
