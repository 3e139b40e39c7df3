#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "capture/capture.h"
#include "tests/pipeline/texture.h"

/// Synthetic bursts whose motion is known exactly, for the tests of align and merge.
namespace dualpixel::pipeline {

/// A target lit by `lux`, gray of reflectance 0.18 at f/1.8 and 1/15 s: 4.06 e per lux on a photosite of 1.4 um. The
/// ISO puts that gray at 0.108 of the white level; full well 6000 e at ISO 100, read noise 2 e, 10 bits.
inline constexpr double kGrayLevel = 0.108;
inline Exposure exposure_at(double lux) {
  const double electrons = 4.06 * lux;
  Exposure exposure;
  exposure.black_level_dn = 64;
  exposure.white_level_dn = 1023;
  const double gain = kGrayLevel * 959 / electrons;  // DN per electron
  exposure.mosaic_noise = {gain, gain * gain * 4 + 1.0 / 12};
  exposure.dp_noise = {gain / 4, gain * gain + 1.0 / 12};
  return exposure;
}

/// How a frame sees the target: texture(center + (p - center - motion) * zoom), in Bayer px.
struct Pose {
  double x = 0, y = 0, zoom = 1;
};

/// A textured target: octaves of equal contrast, as in pictures of natural things; mean 1, deviation `contrast`.
class Target {
 public:
  explicit Target(unsigned seed, double contrast = 0.35) : contrast_(contrast) {
    for (const double highest : {0.35, 0.12, 0.04, 0.012}) octaves_.emplace_back(seed++, highest);
  }

  /// width x height samples, the first at (x0, y0) of the Bayer plane's continuous coordinates.
  Image raster(int width, int height, double x0, double y0, double step_x, double step_y) const {
    Image sum(width, height, 1, 1.0f);
    const double scale = contrast_ / std::sqrt(0.5 * static_cast<double>(octaves_.size()));
    for (const Texture& octave : octaves_) {
      const Image part = octave.raster(width, height, x0, step_x, y0, step_y);
      for (std::size_t i = 0; i < sum.data.size(); ++i) sum.data[i] += static_cast<float>(scale * part.data[i]);
    }
    return sum;
  }

 private:
  double contrast_;
  std::vector<Texture> octaves_;
};

/// Noiseless signals, normalized: a mosaic of 2 width x 2 height photosites (of colors 0.7, 1, 0.6), and DP views of
/// width x height / 2 pixels with right(x + disparity) = left(x). Views average four rows of photosites.
struct Signals {
  Image mosaic, left, right;
};
inline Signals see(const Target& target, int width, int height, const Pose& pose, double disparity_dp_px = 0) {
  const auto raster = [&](int w, int h, double x0, double y0, double step_y) {
    return target.raster(w, h, width / 2.0 + (x0 - width / 2.0 - pose.x) * pose.zoom,
                         height / 2.0 + (y0 - height / 2.0 - pose.y) * pose.zoom, pose.zoom, step_y * pose.zoom);
  };
  Signals signals{Image(2 * width, 2 * height), Image(width, height / 2), Image(width, height / 2)};
  for (int v = 0; v < 2; ++v) {
    for (int u = 0; u < 2; ++u) {
      const double level = kGrayLevel * (u != v ? 1.0 : u == 0 ? 0.7 : 0.6);
      const Image plane = raster(width, height, (u + 0.5) / 2, (v + 0.5) / 2, 1);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          signals.mosaic.at(2 * x + u, 2 * y + v) = static_cast<float>(level * plane.at(x, y));
        }
      }
    }
  }
  for (const int side : {-1, 1}) {
    Image& view = side < 0 ? signals.left : signals.right;
    for (int row = 0; row < 4; ++row) {
      const Image rows = raster(width, height / 2, 0.5 - side * disparity_dp_px / 2, (row + 0.5) / 2, 2);
      for (std::size_t i = 0; i < view.data.size(); ++i) {
        view.data[i] += static_cast<float>(kGrayLevel / 8) * rows.data[i];
      }
    }
  }
  return signals;
}

/// Digital numbers with the exposure's noise; its part of the random numbers is `random`'s.
inline ImageU16 expose(const Image& signal, const Exposure& exposure, const NoiseProfile& noise, std::mt19937& random) {
  std::normal_distribution<double> normal;
  ImageU16 raw(signal.width, signal.height);
  for (std::size_t i = 0; i < raw.data.size(); ++i) {
    const double dn = signal.data[i] * (exposure.white_level_dn - exposure.black_level_dn);
    const double variance = std::max(noise.shot_dn * dn + noise.read_dn2 - 1.0 / 12, 0.0);  // rounding adds 1/12
    const double noisy = exposure.black_level_dn + dn + std::sqrt(variance) * normal(random);
    raw.data[i] = static_cast<std::uint16_t>(std::clamp(std::round(noisy), 0.0, exposure.white_level_dn));
  }
  return raw;
}
inline Frame expose(const Signals& signals, const Exposure& exposure, unsigned seed) {
  std::mt19937 random(seed);
  Frame frame;
  frame.mosaic = expose(signals.mosaic, exposure, exposure.mosaic_noise, random);
  frame.left = expose(signals.left, exposure, exposure.dp_noise, random);
  frame.right = expose(signals.right, exposure, exposure.dp_noise, random);
  return frame;
}

/// Six poses of a hand-held burst: some Bayer px of drift, fractions of all sizes, a little motion along the axis.
inline const std::array<Pose, 6> kHandShake = {{{0, 0, 1},
                                                {1.31, -0.72, 1},
                                                {2.87, -2.05, 1.001},
                                                {3.44, -4.61, 1.001},
                                                {6.18, -5.27, 0.998},
                                                {9.53, -3.9, 0.997}}};

inline std::vector<Frame> hand_held(const Target& target, int width, int height, const Exposure& exposure,
                                    unsigned seed) {
  std::vector<Frame> frames;
  for (const Pose& pose : kHandShake) frames.push_back(expose(see(target, width, height, pose), exposure, seed++));
  return frames;
}

/// Mosaics smaller than a tile, or hardly larger: (width, height) in photosites.
inline const std::array<std::pair<int, int>, 4> kSmallestMosaics = {{{2, 2}, {2, 40}, {38, 2}, {18, 22}}};

/// Three frames without texture, but for one bright photosite of the second.
inline std::vector<Frame> flat_frames(int width, int height) {
  std::vector<Frame> frames(3);
  for (Frame& frame : frames) {
    frame.mosaic = ImageU16(width, height, 1, 100);
    frame.left = frame.right = ImageU16(width / 2, (height + 3) / 4, 1, 80);
  }
  frames[1].mosaic.at(1, 1) = 1000;
  return frames;
}

}  // namespace dualpixel::pipeline
