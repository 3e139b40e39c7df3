#include "pipeline/burst/align.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "capture/image/resample.h"
#include "capture/image/rows.h"
#include "capture/lanes.h"
#include "pipeline/burst/require.h"

namespace dualpixel::pipeline {
namespace {

struct Level {
  int shrink;    ///< from the next finer level
  int tile_px;   ///< kLanes or a multiple
  int range_px;  ///< searched around the coarser level's motion
};
constexpr Level kLevels[] = {{1, kMotionTile, 1}, {2, 16, 4}, {4, 16, 4}, {4, 8, 4}};
constexpr int kLevelCount = 4;

using Pyramid = std::vector<Image>;

/// Mean of factor x factor pixels, the last row and column repeated to fill the last cells.
Image shrink(const Image& image, int factor) {
  Image small((image.width + factor - 1) / factor, (image.height + factor - 1) / factor);
  const float weight = 1.0f / static_cast<float>(factor * factor);
  const int whole = image.width / factor;
  for_rows(small.height, [&](int y) {
    float* to = small.row(y);
    for (int v = 0; v < factor; ++v) {
      const float* from = image.row(std::min(y * factor + v, image.height - 1));
      for (int u = 0; u < factor; ++u) {
        for (int x = 0; x < whole; ++x) to[x] += from[x * factor + u];
        if (whole < small.width) to[whole] += from[std::min(whole * factor + u, image.width - 1)];
      }
    }
    for (int x = 0; x < small.width; ++x) to[x] *= weight;
  });
  return small;
}

Image gray(const Frame& frame, const Exposure& exposure) {
  const auto scale = static_cast<float>(1 / (exposure.white_level_dn - exposure.black_level_dn));
  const auto black = static_cast<float>(exposure.black_level_dn);
  if (frame.mosaic.empty()) {
    Image sum(frame.left.width, frame.left.height);
    for (std::size_t i = 0; i < sum.data.size(); ++i) {
      sum.data[i] = (static_cast<float>(frame.left.data[i] + frame.right.data[i]) - 2 * black) * scale;
    }
    const auto [width, height] = plane_size(frame);
    return resize_bilinear(sum, width, height);
  }
  Image mean(frame.mosaic.width / 2, frame.mosaic.height / 2);
  for_rows(mean.height, [&](int y) {
    const std::uint16_t* upper = frame.mosaic.row(2 * y);
    const std::uint16_t* lower = frame.mosaic.row(2 * y + 1);
    float* to = mean.row(y);
    for (int x = 0; x < mean.width; ++x) {
      const int four = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
      to[x] = (0.25f * static_cast<float>(four) - black) * scale;
    }
  });
  return mean;
}

Pyramid make_pyramid(const Frame& frame, const Exposure& exposure) {
  Pyramid pyramid = {gray(frame, exposure)};
  for (int level = 1; level < kLevelCount; ++level) {
    pyramid.push_back(shrink(pyramid.back(), kLevels[level].shrink));
  }
  return pyramid;
}

/// A square of an image, copied so that it may reach beyond the border, where the outermost pixels are repeated.
template <int side>
struct Patch {
  alignas(Lanes) float at[side][side];

  Patch(const Image& image, int x0, int y0) {
    const bool inside = x0 >= 0 && x0 + side <= image.width;
    for (int y = 0; y < side; ++y) {
      const float* row = image.row(std::clamp(y0 + y, 0, image.height - 1));
      if (inside) {
        std::copy_n(row + x0, side, at[y]);
      } else {
        for (int x = 0; x < side; ++x) at[y][x] = row[std::clamp(x0 + x, 0, image.width - 1)];
      }
    }
  }
};

enum class Norm { absolute, squared };

/// Sum over a tile x tile square of the differences between `base` and `other`, whose rows are `stride` apart.
template <Norm norm, int tile>
float cost(const Patch<tile>& base, const float* other, int stride) {
  constexpr int kAcross = tile / kLanes;
  Lanes sums[2][kAcross] = {};  // of even and odd rows: shorter chains of additions
  for (int y = 0; y < tile; ++y) {
    for (int h = 0; h < kAcross; ++h) {
      const Lanes difference = load_lanes(base.at[y] + kLanes * h) - load_lanes(other + y * stride + kLanes * h);
      sums[y & 1][h] += norm == Norm::squared ? difference * difference : difference < 0 ? -difference : difference;
    }
  }
  Lanes all = sums[0][0] + sums[1][0];
  for (int h = 1; h < kAcross; ++h) all += sums[0][h] + sums[1][h];
  return sum(all);
}

struct Shift {
  int x = 0, y = 0;
};
struct Motion {
  float x = 0, y = 0;
};

/// Minimum of the quadratic fitted to 3 x 3 costs by weighted least squares (Hasinoff et al. 2016, supplement); (0, 0)
/// where it is no minimum or lies outside.
Motion quadratic_minimum(const float (&c)[3][3]) {
  const float across[3] = {c[0][0] - 2 * c[0][1] + c[0][2], c[1][0] - 2 * c[1][1] + c[1][2],
                           c[2][0] - 2 * c[2][1] + c[2][2]};
  const float down[3] = {c[0][0] - 2 * c[1][0] + c[2][0], c[0][1] - 2 * c[1][1] + c[2][1],
                         c[0][2] - 2 * c[1][2] + c[2][2]};
  const float xx = 0.25f * (across[0] + 2 * across[1] + across[2]);
  const float yy = 0.25f * (down[0] + 2 * down[1] + down[2]);
  float xy = 0.25f * (c[0][0] - c[0][2] - c[2][0] + c[2][2]);
  const float gx = 0.125f * (c[0][2] - c[0][0] + 2 * (c[1][2] - c[1][0]) + c[2][2] - c[2][0]);
  const float gy = 0.125f * (c[2][0] - c[0][0] + 2 * (c[2][1] - c[0][1]) + c[2][2] - c[0][2]);
  if (!(xx > 0 && yy > 0)) return {};
  if (xx * yy <= xy * xy) xy = 0;
  const float determinant = xx * yy - xy * xy;
  const Motion minimum = {(xy * gy - yy * gx) / determinant, (xy * gx - xx * gy) / determinant};
  if (!(std::abs(minimum.x) <= 1 && std::abs(minimum.y) <= 1)) return {};
  return minimum;
}

/// The shift that fits the tile at (x0, y0) best: around `start`, within +-range, with a fraction.
template <int tile, int range, Norm norm>
Motion search(const Patch<tile>& base, const Image& other, int x0, int y0, Shift start) {
  constexpr int kRim = range + 1;  // one more, for the quadratic
  constexpr int kSide = tile + 2 * kRim;
  const Patch<kSide> window(other, x0 + start.x - kRim, y0 + start.y - kRim);
  const auto shifted = [&](int x, int y) { return &window.at[y + kRim][x + kRim]; };
  Shift best;
  float least = cost<norm, tile>(base, shifted(0, 0), kSide);
  for (int y = -range; y <= range; ++y) {
    for (int x = -range; x <= range; ++x) {
      const float c = cost<norm, tile>(base, shifted(x, y), kSide);
      if (c < least) {
        least = c;
        best = {x, y};
      }
    }
  }
  float around[3][3];
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      around[y][x] = cost<Norm::squared, tile>(base, shifted(best.x + x - 1, best.y + y - 1), kSide);
    }
  }
  const Motion fraction = quadratic_minimum(around);
  return {static_cast<float>(start.x + best.x) + fraction.x, static_cast<float>(start.y + best.y) + fraction.y};
}

/// Tile i along an axis of `size` px begins here: centered on its corner, but moved into the picture.
int tile_begin(int i, int tile, int size) { return std::clamp(i * tile / 2 - tile / 2, 0, std::max(size - tile, 0)); }

int tile_count(int size, int tile) { return (size + tile / 2 - 1) / (tile / 2) + 1; }

/// The coarser level's tile that is nearest to tile i of `step` px, and the next nearest.
struct Nearest {
  int first, second;
};
Nearest nearest(int i, int step, int coarse_step, int count) {
  const double at = static_cast<double>(i) * step / coarse_step;
  const int first = std::min(static_cast<int>(std::lround(at)), count - 1);
  return {first, std::clamp(at < first ? first - 1 : first + 1, 0, count - 1)};
}

template <int level>
MotionField align_level(const Image& base, const Image& other, const MotionField& coarse) {
  constexpr int kSide = kLevels[level].tile_px;
  constexpr Norm kNorm = level == 0 ? Norm::absolute : Norm::squared;
  MotionField motion(tile_count(base.width, kSide), tile_count(base.height, kSide), 2);
  for_rows(motion.height, [&](int j) {
    for (int i = 0; i < motion.width; ++i) {
      const int x0 = tile_begin(i, kSide, base.width), y0 = tile_begin(j, kSide, base.height);
      const Patch<kSide> tile(base, x0, y0);
      Shift start;
      if constexpr (level + 1 < kLevelCount) {
        constexpr int kGrow = kLevels[level + 1].shrink;
        constexpr int kCoarseStep = kGrow * kLevels[level + 1].tile_px / 2;
        const Nearest u = nearest(i, kSide / 2, kCoarseStep, coarse.width);
        const Nearest v = nearest(j, kSide / 2, kCoarseStep, coarse.height);
        const auto candidate = [&](int x, int y) {
          return Shift{static_cast<int>(std::lround(kGrow * coarse.at(x, y, 0))),
                       static_cast<int>(std::lround(kGrow * coarse.at(x, y, 1)))};
        };
        const Shift candidates[] = {candidate(u.first, v.first), candidate(u.second, v.first),
                                    candidate(u.first, v.second)};
        start = candidates[0];
        float least = -1;  // not known yet: mostly all three are the same
        for (int k = 1; k < 3; ++k) {
          const Shift& next = candidates[k];
          if (next.x == start.x && next.y == start.y) continue;
          const auto cost_of = [&](const Shift& shift) {
            const Patch<kSide> there(other, x0 + shift.x, y0 + shift.y);
            return cost<Norm::absolute, kSide>(tile, there.at[0], kSide);
          };
          if (least < 0) least = cost_of(start);
          const float c = cost_of(next);
          if (c < least) {
            least = c;
            start = next;
          }
        }
      }
      const Motion found = search<kSide, kLevels[level].range_px, kNorm>(tile, other, x0, y0, start);
      motion.at(i, j, 0) = found.x;
      motion.at(i, j, 1) = found.y;
    }
  });
  return motion;
}

MotionField align_frame(const Pyramid& base, const Pyramid& other) {
  MotionField motion = align_level<3>(base[3], other[3], {});
  motion = align_level<2>(base[2], other[2], motion);
  motion = align_level<1>(base[1], other[1], motion);
  return align_level<0>(base[0], other[0], motion);
}

void require_profile(const NoiseProfile& noise, const std::string& field) {
  const auto require_variance = [&](const char* name, double value) {
    require(std::isfinite(value) && value >= 0,
            fmt::format("{}.{}: {}: must be finite and not negative", field, name, value));
  };
  require_variance("shot_dn", noise.shot_dn);
  require_variance("read_dn2", noise.read_dn2);
}

bool whole(const ImageU16& image) {
  return image.width > 0 && image.height > 0 && image.channels == 1 && image.data.size() == image.pixel_count();
}

/// Sum of squared differences between neighbors, of the pixels begin + step * i of every step-th row.
double gradient_energy(const ImageU16& image, int begin, int step) {
  std::vector<double> rows(image.height, 0.0);  // added up in order, whatever thread computed them
  for_rows(image.height, [&](int y) {
    if (y % step != 0) return;
    const std::uint16_t* row = image.row(y) + begin;
    const std::uint16_t* below = image.row(y + step < image.height ? y + step : y) + begin;
    float energy = 0;
    for (int x = 0; x + begin + step < image.width; x += step) {
      const auto across = static_cast<float>(row[x + step] - row[x]), down = static_cast<float>(below[x] - row[x]);
      energy += across * across + down * down;
    }
    rows[y] = energy;
  });
  double total = 0;
  for (const double energy : rows) total += energy;
  return total;
}

}  // namespace

PlaneSize plane_size(const Frame& frame) {
  if (frame.mosaic.empty()) return {frame.left.width, 2 * frame.left.height};
  return {frame.mosaic.width / 2, frame.mosaic.height / 2};
}

void require_burst(const std::vector<Frame>& frames, const Exposure& exposure) {
  require(!frames.empty(), "no frames");
  const Frame& first = frames.front();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame& frame = frames[i];
    const std::string name = "frame " + std::to_string(i) + ": ";
    const bool without_views = frame.left.empty() && frame.right.empty() && !frame.mosaic.empty();
    require(without_views || (whole(frame.left) && whole(frame.right)),
            name + "left and right must be whole images of one channel");
    require(frame.left.same_size(first.left) && frame.right.same_size(first.left),
            name + "left and right must have the size of the first frame's left");
    require(frame.mosaic.empty() == first.mosaic.empty(), name + "either every frame has a mosaic or none");
    if (frame.mosaic.empty()) continue;
    require(whole(frame.mosaic) && frame.mosaic.width % 2 == 0 && frame.mosaic.height % 2 == 0,
            name + "mosaic must be a whole image of one channel with even sides");
    require(frame.mosaic.same_size(first.mosaic), name + "mosaic must have the size of the first frame's");
  }
  require(std::isfinite(exposure.black_level_dn) && std::isfinite(exposure.white_level_dn) &&
              exposure.white_level_dn > exposure.black_level_dn,
          fmt::format("white_level_dn: {}: must be finite and above black_level_dn, {}", exposure.white_level_dn,
                      exposure.black_level_dn));
  require_profile(exposure.mosaic_noise, "mosaic_noise");
  require_profile(exposure.dp_noise, "dp_noise");
}

int sharpest_frame(const std::vector<Frame>& frames, const Exposure& exposure) {
  constexpr std::size_t kCandidates = 3;
  constexpr double kClearly = 1.01;
  require_burst(frames, exposure);
  int best = 0;
  double most = -1;
  for (std::size_t i = 0; i < std::min(frames.size(), kCandidates); ++i) {
    // photosites (1, 0) of each 2 x 2: green in RGGB and BGGR
    const double energy =
        frames[i].mosaic.empty() ? gradient_energy(frames[i].left, 0, 1) : gradient_energy(frames[i].mosaic, 1, 2);
    if (most < 0 || energy > kClearly * most) {
      most = energy;
      best = static_cast<int>(i);
    }
  }
  return best;
}

std::vector<MotionField> align_burst(const std::vector<Frame>& frames, int base, const Exposure& exposure) {
  require_burst(frames, exposure);
  require(base >= 0 && base < static_cast<int>(frames.size()),
          fmt::format("base: {}: must be in [0, {}]", base, frames.size() - 1));
  const Pyramid reference = make_pyramid(frames[base], exposure);
  std::vector<MotionField> motions;
  for (int z = 0; z < static_cast<int>(frames.size()); ++z) {
    if (z == base) {
      motions.emplace_back(motion_tiles(reference[0].width), motion_tiles(reference[0].height), 2);
    } else {
      motions.push_back(align_frame(reference, make_pyramid(frames[z], exposure)));
    }
  }
  return motions;
}

}  // namespace dualpixel::pipeline
