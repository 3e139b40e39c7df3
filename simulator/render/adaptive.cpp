#include "simulator/render/adaptive.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"

namespace dualpixel::simulator {
namespace {

constexpr std::uint32_t kFirstCount = 8, kGrowth = 4;
constexpr int kProbeSide = 4;  ///< one photosite of each 4 x 4 is probed
constexpr std::uint64_t kPilotStream = 0x70696c6f74;

/// Mean square error over the allowed one at the counts 8, 32, 128, ...
using ErrorCurve = std::vector<double>;

/// Of the photosites of one tile that are probed, at one sample count.
double probe_tile(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
                  const ErrorTarget& target, const Tile& tile, std::uint32_t samples) {
  const PathOptions paths{options.max_bounces, options.ideal_aperture_scale, options.sampling, options.color};
  double sum = 0;
  int count = 0;
  for (int y = tile.y0; y < tile.y1; y += kProbeSide) {
    for (int x = tile.x0; x < tile.x1; x += kProbeSide) {
      const std::uint64_t key =
          hash(options.seed, kPilotStream, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x));
      const int px = std::min(x + static_cast<int>(key % kProbeSide), tile.x1 - 1);
      const int py = std::min(y + static_cast<int>(key / kProbeSide % kProbeSide), tile.y1 - 1);
      const int c = cfa_color(px, py);
      const HalfRadiance a = render_pixel(world, camera, paths, px, py, samples, hash(key, samples, 0));
      const HalfRadiance b = render_pixel(world, camera, paths, px, py, samples, hash(key, samples, 1));
      for (const auto& [one, other] : {std::pair{a.left[c], b.left[c]}, {a.right[c], b.right[c]}}) {
        const double difference = one - other;
        const double allowed = target.at(c, 0.5 * (one + other));
        if (difference != 0) sum += 0.5 * difference * difference / std::max(allowed, 1e-30);
        ++count;
      }
    }
  }
  return sum / count;
}

/// The count at which the curve, extrapolated at its last slope, comes down to 1. A net's variance falls at least as
/// 1/N.
double samples_needed(const ErrorCurve& curve, double& slope) {
  const double last = kFirstCount * std::pow(double{kGrowth}, static_cast<double>(curve.size()) - 1);
  slope = 1;
  if (curve.size() > 1) {
    const double fall = curve[curve.size() - 2] / std::max(curve.back(), 1e-30);
    slope = std::clamp(std::log(fall) / std::log(double{kGrowth}), 1.0, 2.0);
  }
  return last * std::pow(curve.back(), 1 / slope);
}

}  // namespace

Pilot probe_tiles(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
                  const ErrorTarget& target, std::uint32_t most_samples, const ProgressCallback& progress) {
  const SensorGrid& sensor = camera.lens.sensor();
  Pilot pilot;
  pilot.grid = uniform_map(sensor.width_px, sensor.height_px, SampleLimits{}.fewest);
  const SampleMap& map = pilot.grid;
  std::vector<ErrorCurve> curves(map.samples.size());
  const double levels = std::log(static_cast<double>(most_samples) / kFirstCount) / std::log(double{kGrowth}) + 1;
  std::uint32_t samples = kFirstCount;
  for (int level = 0;; ++level, samples *= kGrowth) {
    // The last step is cheaper to extrapolate than to measure.
    const auto wanted = [&](const ErrorCurve& curve) {
      return level == 0 || (curve.size() == static_cast<std::size_t>(level) && curve.back() > kGrowth);
    };
    if (samples > most_samples || std::none_of(curves.begin(), curves.end(), wanted)) break;
    for_tiles(map, [&](const Tile& tile) {
      ErrorCurve& curve = curves[tile.index];
      if (wanted(curve)) curve.push_back(probe_tile(world, camera, options, target, tile, samples));
    });
    for (std::size_t i = 0; i < curves.size(); ++i) {
      if (curves[i].size() != static_cast<std::size_t>(level) + 1) continue;
      const Tile t = tile_at(map, static_cast<int>(i));
      const int probes = (t.x1 - t.x0 + kProbeSide - 1) / kProbeSide * ((t.y1 - t.y0 + kProbeSide - 1) / kProbeSide);
      pilot.samples += 2.0 * probes * std::max(samples, 16u);
    }
    if (progress) progress(std::min((level + 1) / levels, 1.0));
  }

  std::vector<double> own(curves.size());
  pilot.slope.resize(curves.size());
  for (std::size_t i = 0; i < curves.size(); ++i) own[i] = samples_needed(curves[i], pilot.slope[i]);
  for (int i = 0; i < static_cast<int>(curves.size()); ++i) {
    // Sixteen probes scatter; a tile whose own say little is helped by those around it.
    const int column = i % map.columns(), row = i / map.columns();
    double log_sum = 0;
    int count = 0;
    for (int v = std::max(row - 1, 0); v <= std::min(row + 1, map.rows() - 1); ++v) {
      for (int u = std::max(column - 1, 0); u <= std::min(column + 1, map.columns() - 1); ++u, ++count) {
        log_sum += std::log(std::max(own[v * map.columns() + u], 1.0));
      }
    }
    // none of them needs a whole sample: the error of more is stated by what the tile itself says
    const double around = std::exp(log_sum / count);
    pilot.needed.push_back(around > 1 ? std::max(own[i], around) : own[i]);
  }
  if (progress) progress(1);
  return pilot;
}

namespace {

/// Mean square error over the allowed one of tile i with n samples.
double error2(const Pilot& pilot, std::size_t i, double n) { return std::pow(pilot.needed[i] / n, pilot.slope[i]); }

/// Least work for a given sum of squares: another sample must gain the same, `gain`, everywhere.
double samples_at(const Pilot& pilot, std::size_t i, double gain, const SampleLimits& limits) {
  const double s = pilot.slope[i];
  return std::clamp(std::pow(s * std::pow(pilot.needed[i], s) / gain, 1 / (s + 1)), 1.0 * limits.fewest,
                    1.0 * limits.most);
}

SampleMap map_at_gain(const Pilot& pilot, double gain, const SampleLimits& limits) {
  SampleMap map = pilot.grid;
  map.error_ratio.resize(pilot.needed.size());
  double carried = 0;
  for (std::size_t i = 0; i < pilot.needed.size(); ++i) {
    // Powers of two sample far better than what lies between, so some tiles get the one below and some the one above;
    // what a tile's square error has too much is carried to the next.
    const double n = samples_at(pilot, i, gain, limits), below = std::exp2(std::floor(std::log2(n)));
    const double e = error2(pilot, i, n), e_below = error2(pilot, i, below), e_above = error2(pilot, i, 2 * below);
    const bool above = std::abs(carried + e_above - e) < std::abs(carried + e_below - e) && 2 * below <= limits.most;
    carried += (above ? e_above : e_below) - e;
    map.samples[i] = static_cast<std::uint32_t>(above ? 2 * below : below);
    map.error_ratio[i] = static_cast<float>(std::sqrt(error2(pilot, i, map.samples[i])));
  }
  return map;
}

struct Bracket {
  double low = 1e-12, high = 1e6;
};

/// Closes in on the gain up to which `more_than_enough` is true of the samples.
template <class MoreThanEnough>
Bracket bisect_gain(const MoreThanEnough& more_than_enough) {
  Bracket gain;
  for (int step = 0; step < 60; ++step) {
    const double middle = std::sqrt(gain.low * gain.high);
    (more_than_enough(middle) ? gain.low : gain.high) = middle;
  }
  return gain;
}

}  // namespace

SampleMap share_samples(const Pilot& pilot, double error, const SampleLimits& limits) {
  const double allowed = error * error * static_cast<double>(pilot.needed.size());
  const Bracket gain = bisect_gain([&](double g) {
    double sum = 0;
    for (std::size_t i = 0; i < pilot.needed.size(); ++i) sum += error2(pilot, i, samples_at(pilot, i, g, limits));
    return sum <= allowed;
  });
  return map_at_gain(pilot, gain.low, limits);
}

SampleMap share_budget(const Pilot& pilot, const std::function<double()>& affordable, const SampleLimits& limits) {
  const Bracket gain =
      bisect_gain([&](double g) { return map_at_gain(pilot, g, limits).total_samples() > affordable(); });
  return map_at_gain(pilot, gain.high, limits);
}

}  // namespace dualpixel::simulator
