#include "simulator/render/render_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/render/pixel.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/sensor_grid.h"

namespace dualpixel::simulator {
namespace {

constexpr std::uint64_t kStream = 0x6572726f72;

struct Probe {
  int x, y;
};

/// One photosite of each square cell of the sensor.
std::vector<Probe> probes_of(const SensorGrid& sensor, std::uint64_t seed) {
  constexpr double kShare = 0.002, kFewest = 64;
  const double area = static_cast<double>(sensor.width_px) * sensor.height_px;
  const double cells = std::clamp(kShare * area, std::min(kFewest, area), area);
  const int side = std::max(static_cast<int>(std::sqrt(area / cells)), 1);
  std::vector<Probe> probes;
  for (int y = 0; y < sensor.height_px; y += side) {
    for (int x = 0; x < sensor.width_px; x += side) {
      const std::uint64_t key = hash(seed, kStream, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x));
      probes.push_back({std::min(x + static_cast<int>(key % side), sensor.width_px - 1),
                        std::min(y + static_cast<int>((key >> 32) % side), sensor.height_px - 1)});
    }
  }
  return probes;
}

std::vector<HalfRadiance> render_probes(const RenderScene& world, const CameraView& camera,
                                        const RenderOptions& options, const std::vector<Probe>& probes,
                                        std::uint32_t samples, int scramble) {
  const PathOptions paths{options.max_bounces, options.ideal_aperture_scale, options.sampling, options.color};
  std::vector<HalfRadiance> out(probes.size());
  tbb::parallel_for(std::size_t{0}, probes.size(), [&](std::size_t i) {
    out[i] = render_pixel(world, camera, paths, probes[i].x, probes[i].y, samples,
                          hash(hash(options.seed, kStream, i), scramble));
  });
  return out;
}

/// Half the mean square difference over what is allowed.
double half_difference(const std::vector<HalfRadiance>& a, const std::vector<HalfRadiance>& b,
                       const std::vector<Probe>& probes, const ErrorTarget& target) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int c = cfa_color(probes[i].x, probes[i].y);
    for (const auto& [one, other] : {std::pair{a[i].left[c], b[i].left[c]}, {a[i].right[c], b[i].right[c]}}) {
      const double difference = one - other;
      const double allowed = target.at(c, 0.5 * (one + other));
      sum += 0.25 * difference * difference / std::max(allowed, 1e-30);
    }
  }
  return sum / static_cast<double>(a.size());
}

}  // namespace

RenderError estimate_error(RenderScene& world, const CameraView& camera, const RenderOptions& options,
                           const ErrorTarget& target, std::uint32_t samples) {
  const std::vector<Probe> probes = probes_of(camera.lens.sensor(), options.seed);
  const auto render = [&](int scramble) { return render_probes(world, camera, options, probes, samples, scramble); };
  const std::vector<HalfRadiance> first = render(0);
  RenderError error{half_difference(first, render(1), probes, target), 0};
  if (!world.light_cache) return error;
  const LightCacheOptions light = world.light_cache->options;
  const std::uint64_t scramble = world.light_cache->scramble;
  use_light(world, light, scramble + 1);
  error.light = half_difference(first, render(0), probes, target);
  use_light(world, light, scramble);
  return error;
}

double light_error(double error, int at, int samples) {
  // Light samples are a net over the lights: their variance falls faster than that of independent ones.
  constexpr double kFall = 1.3;
  return error * std::pow(static_cast<double>(at) / samples, kFall);
}

int light_samples_for(double allowed, double error, int at) {
  constexpr int kFewest = 16, kMost = 4096;
  int samples = kFewest;
  while (samples < kMost && light_error(error, at, samples) > allowed) samples *= 2;
  return samples;
}

}  // namespace dualpixel::simulator
