#include "scenes/framing/light_meter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "capture/error.h"
#include "simulator/render/pixel.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"

namespace dualpixel::scenes {
namespace {

/// Green signal over the white level at 1 s and ISO 100, of one photosite in each cell of a grid.
std::vector<double> green_signals(const simulator::Simulation& s, const simulator::RenderScene& world,
                                  const simulator::CameraView& camera) {
  constexpr int kColumns = 48, kRows = 36;
  constexpr std::uint32_t kSamples = 4;
  constexpr std::uint64_t kStream = 0x6d65746572;
  const simulator::PathOptions paths{s.render.max_bounces, {}, s.render.sampling};
  const double signal_per_nit = camera.lens.lux_per_nit() * s.sensor.electrons_per_lux_s[1] / s.sensor.full_well_e;
  std::vector<double> signals(std::size_t{kColumns} * kRows);
  tbb::parallel_for(std::size_t{0}, signals.size(), [&](std::size_t i) {
    const int column = static_cast<int>(i) % kColumns, row = static_cast<int>(i) / kColumns;
    int x = (2 * column + 1) * s.sensor.width_px / (2 * kColumns);
    const int y = (2 * row + 1) * s.sensor.height_px / (2 * kRows);
    if (simulator::cfa_color(x, y) != 1) x ^= 1;
    const auto seen =
        simulator::render_pixel(world, camera, paths, x, y, kSamples, simulator::hash(s.render.seed, kStream, i));
    const glm::dvec3 light(seen.left + seen.right);
    const glm::dvec3 filter(s.sensor.color_matrix[3], s.sensor.color_matrix[4], s.sensor.color_matrix[5]);
    signals[i] = signal_per_nit * std::max(glm::dot(filter, light), 0.0);
  });
  return signals;
}

/// The factor by which the mean of the clipped signals becomes `mean`, by bisection of its logarithm.
double exposure_factor(const std::vector<double>& signals, double mean, const WhiteOfExposure& white) {
  double low = std::log(1e-12), high = std::log(1e12);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high), factor = std::exp(middle);
    const double most = white(factor);
    double sum = 0;
    for (const double signal : signals) sum += std::min(most, factor * signal);
    (sum < mean * static_cast<double>(signals.size()) ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

std::optional<MissedExposure> MeteredExposure::missed(std::optional<MissedExposure> by_camera) const {
  if (reaches_mean) return by_camera;
  if (!by_camera) by_camera = {{.limit_s = seconds, .taken_s = seconds}};
  by_camera->asked_s = std::numeric_limits<double>::infinity();
  return by_camera;
}

MeteredExposure meter_for_mean(double mean, const simulator::Simulation& s, simulator::ReadyScene& ready,
                               const simulator::CameraView& camera, const char* field, const WhiteOfExposure& white) {
  // without the light that other samples left, of which there may be more or less
  std::unique_ptr<simulator::LightCache> kept;
  kept.swap(ready.world.light_cache);
  const std::vector<double> signals = green_signals(s, ready.world, camera);
  kept.swap(ready.world.light_cache);
  const double most = signals.empty() ? 0 : *std::max_element(signals.begin(), signals.end());
  if (!(most > 0)) throw InputError(printable(s.path) + ": " + field + ": the camera sees no light");
  const double seconds = exposure_factor(signals, mean, white);
  if (seconds > 1e11) return {white(seconds) / most, false};
  return {seconds};
}

}  // namespace dualpixel::scenes
