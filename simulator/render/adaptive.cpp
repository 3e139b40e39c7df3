#include "simulator/render/adaptive.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/sampling/hash.h"
#include "simulator/sensor/cfa.h"

namespace dualpixel::simulator {
namespace {

constexpr std::uint32_t kFirstCount = 4, kGrowth = 4;
constexpr int kProbeSide = 4;  ///< one photosite of each 4 x 4 is probed
constexpr std::uint64_t kPilotStream = 0x70696c6f74;

/// Mean square error over the allowed one at the counts 4, 16, 64, ...
using ErrorCurve = std::vector<double>;

/// Of the photosites of one tile that are probed, at one sample count.
double probe(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
             const ErrorTarget& target, const Tile& tile, std::uint32_t samples) {
  const PathOptions paths{options.max_bounces, options.ideal_aperture_scale};
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
        const double allowed = target.per_nit[c] * 0.5 * (one + other) + target.constant[c];
        if (difference != 0) sum += 0.5 * difference * difference / std::max(allowed, 1e-30);
        ++count;
      }
    }
  }
  return sum / count;
}

/// Counts that fill their packets and keep three binary digits.
std::uint32_t round_up(double samples, std::uint32_t most) {
  double step = 16;
  while (8 * step < samples) step *= 2;
  return std::clamp(static_cast<std::uint32_t>(std::min(std::ceil(samples / step) * step, 65536.0)), 16u, most);
}

/// The count at which the curve, its last slope drawn on, comes down to 1. A net's variance falls at least as 1/N.
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

Pilot plan_samples(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
                   const ErrorTarget& target, std::uint32_t most_samples, const ProgressCallback& progress) {
  const SensorGrid& sensor = camera.lens.sensor();
  Pilot pilot{uniform_map(sensor.width_px, sensor.height_px, 16), 0};
  SampleMap& map = pilot.map;
  std::vector<ErrorCurve> curves(map.samples.size());
  const double levels = std::log(static_cast<double>(most_samples) / kFirstCount) / std::log(double{kGrowth}) + 1;
  std::uint32_t samples = kFirstCount;
  for (int level = 0;; ++level, samples *= kGrowth) {
    // The last step is cheaper drawn on than measured.
    const auto wanted = [&](const ErrorCurve& curve) {
      return level == 0 || (curve.size() == static_cast<std::size_t>(level) && curve.back() > kGrowth);
    };
    if (samples > most_samples || std::none_of(curves.begin(), curves.end(), wanted)) break;
    for_tiles(map, [&](const Tile& tile) {
      ErrorCurve& curve = curves[tile.index];
      if (wanted(curve)) curve.push_back(probe(world, camera, options, target, tile, samples));
    });
    for (std::size_t i = 0; i < curves.size(); ++i) {
      if (curves[i].size() != static_cast<std::size_t>(level) + 1) continue;
      const Tile t = tile_at(map, static_cast<int>(i));
      const int probes = (t.x1 - t.x0 + kProbeSide - 1) / kProbeSide * ((t.y1 - t.y0 + kProbeSide - 1) / kProbeSide);
      pilot.samples_spent += 2.0 * probes * std::max(samples, 16u);
    }
    if (progress) progress(std::min((level + 1) / levels, 1.0));
  }

  map.error_ratio.resize(curves.size());
  for (std::size_t i = 0; i < curves.size(); ++i) {
    double slope;
    const double needed = samples_needed(curves[i], slope);
    map.samples[i] = round_up(needed, most_samples);
    map.error_ratio[i] = static_cast<float>(std::pow(needed / map.samples[i], 0.5 * slope));
  }
  if (progress) progress(1);
  return pilot;
}

}  // namespace dualpixel::simulator
